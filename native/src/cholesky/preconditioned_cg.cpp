// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/preconditioned_cg.h"

#include <array>
#include <cstddef>

#include "parallel/parallel.h"

namespace arap {

namespace {

/// One coefficient for each of the three right-hand sides.
using Coefficients = Eigen::Array<double, 1, 3>;

/// Numbers of consecutive rows.
template <int width>
using Numbers = Eigen::Array<double, width, 1>;

template <int width>
Eigen::Map<const Numbers<width>> at(const Positions& x, std::ptrdiff_t k) {
  return Eigen::Map<const Numbers<width>>(x.data() + k);
}

template <int width>
Eigen::Map<Numbers<width>> at(Positions& x, std::ptrdiff_t k) {
  return Eigen::Map<Numbers<width>>(x.data() + k);
}

/// The coefficient of each number's right-hand side.
template <int width>
Numbers<width> spread(const Coefficients& a) {
  return a.transpose().template replicate<width / 3, 1>();
}

/// a / b, 0 if b is not positive.
Coefficients ratio(const Coefficients& a, const Coefficients& b) { return (b > 0).select(a / b, Coefficients::Zero()); }

/// Sums body.operator()<width>(k), `count` times Numbers<width> for the numbers from k on, over all rows. Four rows at
/// a time, so that compilers vectorize.
template <int count, class Body>
std::array<Coefficients, count> sums(const Workers& workers, Eigen::Index n_rows, const Body& body) {
  constexpr int kFour = 12;
  using Sums = std::array<Coefficients, count>;
  const auto add = [](Sums a, const Sums& b) {
    for (size_t i = 0; i < count; ++i) a[i] += b[i];
    return a;
  };
  Sums zero;
  zero.fill(Coefficients::Zero());
  const auto of_range = [&](int begin, int end) {
    std::array<Numbers<kFour>, count> fours;
    fours.fill(Numbers<kFour>::Zero());
    std::ptrdiff_t k = 3 * static_cast<std::ptrdiff_t>(begin);
    const std::ptrdiff_t last = 3 * static_cast<std::ptrdiff_t>(end);
    for (; k + kFour <= last; k += kFour) {
      const std::array<Numbers<kFour>, count> part = body.template operator()<kFour>(k);
      for (size_t i = 0; i < count; ++i) fours[i] += part[i];
    }
    Sums sum;
    for (size_t i = 0; i < count; ++i) sum[i] = fours[i].template reshaped<Eigen::RowMajor>(4, 3).colwise().sum();
    for (; k < last; k += 3) {
      const std::array<Numbers<3>, count> part = body.template operator()<3>(k);
      for (size_t i = 0; i < count; ++i) sum[i] += part[i].transpose();
    }
    return sum;
  };
  return parallel_reduce<4096>(workers, static_cast<int>(n_rows), zero, of_range, add);
}

/// The squared error that a step is assumed to leave at least, as a part of it. The ratio of the first steps is no
/// measure: they correct smooth errors, and the rounding of the factor is not smooth.
constexpr double kLeastLeftSquared = 0.03 * 0.03;

}  // namespace

void solve_with_cg(const std::function<void(const Positions& x, Positions& y)>& apply,
                   const std::function<void(Positions& residual, Positions& x)>& solve, Positions& b,
                   const Workers& workers, double accuracy) {
  constexpr int kMostSteps = 50;
  constexpr double kRoundingSquared = 1e-30;
  const Eigen::Index n = b.rows();
  Positions& residual = b;
  Positions x = Positions::Zero(n, 3);
  Positions direction;
  solve(residual, direction);
  Positions next(n, 3);
  Positions product;
  const auto [b_squared, first_slope] = sums<2>(workers, n, [&]<int width>(std::ptrdiff_t k) {
    const auto r = at<width>(residual, k);
    return std::array<Numbers<width>, 2>{r * r, r * at<width>(direction, k)};
  });
  Coefficients slope = first_slope;
  Coefficients last_step_squared = Coefficients::Ones();  // relative to x
  for (int step = 0; step < kMostSteps; ++step) {
    apply(direction, product);
    const Coefficients curvature = sums<1>(workers, n, [&]<int width>(std::ptrdiff_t k) {
      return std::array<Numbers<width>, 1>{at<width>(direction, k) * at<width>(product, k)};
    })[0];
    const Coefficients length = ratio(slope, curvature);
    const auto [r_squared, x_squared] = sums<2>(workers, n, [&]<int width>(std::ptrdiff_t k) {
      auto of_x = at<width>(x, k);
      auto r = at<width>(residual, k);
      of_x += spread<width>(length) * at<width>(direction, k);
      r -= spread<width>(length) * at<width>(product, k);
      return std::array<Numbers<width>, 2>{r * r, of_x * of_x};
    });
    if ((r_squared <= kRoundingSquared * b_squared).all()) break;
    solve(residual, next);
    // Polak and Ribiere's coefficient tolerates a preconditioner whose rounding differs between solves. The residual
    // changed by -length * product.
    const Coefficients turned = sums<1>(workers, n, [&]<int width>(std::ptrdiff_t k) {
      return std::array<Numbers<width>, 1>{at<width>(next, k) * at<width>(product, k)};
    })[0];
    const Coefficients keep = ratio(-length * turned, slope);
    const auto [next_slope, d_squared] = sums<2>(workers, n, [&]<int width>(std::ptrdiff_t k) {
      auto d = at<width>(direction, k);
      d = spread<width>(keep) * d + at<width>(next, k);
      return std::array<Numbers<width>, 2>{at<width>(residual, k) * d, d * d};
    });
    slope = next_slope;
    // Take the next step in full if it is accurate enough: a line search would change it by less than the accuracy.
    const Coefficients step_squared = ratio(d_squared, x_squared);
    const Coefficients left = ratio(step_squared, last_step_squared).max(kLeastLeftSquared).min(1.0);
    last_step_squared = step_squared;
    if ((left * step_squared <= accuracy * accuracy).all()) {
      parallel_for<4096>(workers, static_cast<int>(n), [&](int begin, int end) {
        x.middleRows(begin, end - begin) += direction.middleRows(begin, end - begin);
      });
      break;
    }
  }
  b.swap(x);
}

}  // namespace arap
