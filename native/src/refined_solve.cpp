// SPDX-License-Identifier: GPL-3.0-or-later
#include "refined_solve.h"

#include <array>

#include "parallel.h"

namespace arap {

namespace {

/// The three right-hand sides have coefficients of their own.
using Coefficients = Eigen::Array<double, 1, 3>;

/// a / b, 0 where there is nothing left to divide.
Coefficients ratio(const Coefficients& a, const Coefficients& b) { return (b > 0).select(a / b, Coefficients::Zero()); }

/// Sums of body(begin, end) over all rows.
template <int count, class Body>
std::array<Coefficients, count> sums(const Workers& workers, Eigen::Index n_rows, const Body& body) {
  using Sums = std::array<Coefficients, count>;
  Sums zero;
  zero.fill(Coefficients::Zero());
  return parallel_reduce<4096>(workers, static_cast<int>(n_rows), zero, body, [](Sums a, const Sums& b) {
    for (size_t k = 0; k < count; ++k) a[k] += b[k];
    return a;
  });
}

template <class A, class B>
Coefficients dots(const A& a, const B& b) {
  return a.cwiseProduct(b).colwise().sum().array();
}

}  // namespace

void solve_refined(const std::function<void(const Positions& x, Positions& y)>& apply, const Factorization& factor,
                   Positions& b, const Workers& workers, double accuracy) {
  constexpr int kMostSteps = 50;
  constexpr double kRoundingSquared = 1e-30;
  const Eigen::Index n = b.rows();
  Positions& residual = b;
  Positions x = Positions::Zero(n, 3);
  Positions direction = b;
  factor.solve(direction);
  Positions next(n, 3);
  Positions product;
  const auto [b_squared, first_slope] = sums<2>(workers, n, [&](int begin, int end) {
    const auto r = residual.middleRows(begin, end - begin);
    return std::array{dots(r, r), dots(r, direction.middleRows(begin, end - begin))};
  });
  Coefficients slope = first_slope;
  for (int step = 0; step < kMostSteps; ++step) {
    apply(direction, product);
    const Coefficients curvature = sums<1>(workers, n, [&](int begin, int end) {
      return std::array{dots(direction.middleRows(begin, end - begin), product.middleRows(begin, end - begin))};
    })[0];
    const Coefficients length = ratio(slope, curvature);
    const auto [r_squared, d_squared, x_squared] = sums<3>(workers, n, [&](int begin, int end) {
      const auto d = direction.middleRows(begin, end - begin);
      auto of_x = x.middleRows(begin, end - begin);
      auto r = residual.middleRows(begin, end - begin);
      of_x.array() += d.array().rowwise() * length;
      r.array() -= product.middleRows(begin, end - begin).array().rowwise() * length;
      next.middleRows(begin, end - begin) = r;
      return std::array{dots(r, r), dots(d, d), dots(of_x, of_x)};
    });
    const bool is_solved = (r_squared <= kRoundingSquared * b_squared).all();
    const bool is_still = (length.square() * d_squared <= accuracy * accuracy * x_squared).all();
    if (is_solved || is_still) break;
    factor.solve(next);
    // Polak and Ribiere's coefficient: right also where the preconditioner's rounding differs from solve to solve. The
    // residual changed by -length * product.
    const Coefficients turned = sums<1>(workers, n, [&](int begin, int end) {
      return std::array{dots(next.middleRows(begin, end - begin), product.middleRows(begin, end - begin))};
    })[0];
    const Coefficients keep = ratio(-length * turned, slope);
    slope = sums<1>(workers, n, [&](int begin, int end) {
      auto d = direction.middleRows(begin, end - begin);
      d = (d.array().rowwise() * keep + next.middleRows(begin, end - begin).array()).matrix();
      return std::array{dots(residual.middleRows(begin, end - begin), d)};
    })[0];
  }
  b.swap(x);
}

}  // namespace arap
