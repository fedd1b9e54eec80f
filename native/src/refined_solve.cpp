// SPDX-License-Identifier: GPL-3.0-or-later
#include "refined_solve.h"

namespace arap {

namespace {

/// The three right-hand sides have coefficients of their own.
using Coefficients = Eigen::Array<double, 1, 3>;

Coefficients dots(const Positions& a, const Positions& b) { return a.cwiseProduct(b).colwise().sum().array(); }

/// a / b, 0 where there is nothing left to divide.
Coefficients ratio(const Coefficients& a, const Coefficients& b) { return (b > 0).select(a / b, Coefficients::Zero()); }

}  // namespace

void solve_refined(const std::function<void(const Positions& x, Positions& y)>& apply, const Factorization& factor,
                   Positions& b) {
  constexpr int kMostSteps = 50;
  constexpr double kAccuracy = 1e-15;
  const Coefficients b_squared = dots(b, b);
  Positions residual = b;
  Positions x = Positions::Zero(b.rows(), 3);
  Positions direction = b;
  factor.solve(direction);
  Coefficients slope = dots(residual, direction);
  Positions product;
  for (int step = 0; step < kMostSteps; ++step) {
    apply(direction, product);
    const Coefficients length = ratio(slope, dots(direction, product));
    x.array() += direction.array().rowwise() * length;
    const Positions previous = residual;
    residual.array() -= product.array().rowwise() * length;
    const bool is_solved = (dots(residual, residual) <= kAccuracy * kAccuracy * b_squared).all();
    // What the step changed in x is lost in its last digits.
    const bool is_still = (length.square() * dots(direction, direction) <= kAccuracy * kAccuracy * dots(x, x)).all();
    if (is_solved || is_still) break;
    Positions next = residual;
    factor.solve(next);
    // Polak and Ribiere's coefficient: right also where the preconditioner's rounding differs from solve to solve.
    const Coefficients keep = ratio(dots(next, residual - previous), slope);
    direction = (direction.array().rowwise() * keep + next.array()).matrix();
    slope = dots(residual, direction);
  }
  b = x;
}

}  // namespace arap
