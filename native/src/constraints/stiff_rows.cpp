// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/stiff_rows.h"

#include <utility>

#include "parallel/parallel.h"

namespace arap {

namespace {

constexpr int kMostSteps = 40;

/// The three right-hand sides have coefficients of their own.
using Coefficients = Eigen::Array<double, 1, 3>;

Coefficients dot(const Positions& a, const Positions& b) { return a.cwiseProduct(b).colwise().sum().array(); }

/// a / b, 0 if there is nothing left to divide.
Coefficients ratio(const Coefficients& a, const Coefficients& b) { return (b > 0).select(a / b, Coefficients::Zero()); }

/// x += y diag(a)
void add_scaled(const Positions& y, const Coefficients& a, Positions& x, const Workers& workers) {
  parallel_for<2048>(workers, static_cast<int>(x.rows()), [&](int begin, int end) {
    x.middleRows(begin, end - begin).array() += y.middleRows(begin, end - begin).array().rowwise() * a;
  });
}

/// x = y + x diag(a)
void scale_and_add(const Positions& y, const Coefficients& a, Positions& x, const Workers& workers) {
  parallel_for<2048>(workers, static_cast<int>(x.rows()), [&](int begin, int end) {
    auto part = x.middleRows(begin, end - begin).array();
    part = y.middleRows(begin, end - begin).array() + part.rowwise() * a;
  });
}

}  // namespace

StiffRows::StiffRows(RowMatrix rows, const Eigen::VectorXd& penalties, const Eigen::VectorXd& weights, Workers workers)
    : rows_(std::move(rows)),
      penalties_(penalties.array()),
      compliance_(1 / (weights - penalties).array()),
      beyond_penalties_(1 - penalties.array() / weights.array()),
      scaling_(1 / (1 / penalties.array() + compliance_)),
      workers_(std::move(workers)) {}

// With F = A + H^T P H, x = F^-1 (b + H^T (P g - f)), and f = (W - P) (H x - g) where it is the minimizer. A change of
// f by df moves x by -F^-1 H^T df. So df solves
//     S df = H x - g - f / (W - P),  S = H F^-1 H^T + 1 / (W - P).
void StiffRows::solve(double accuracy, const Solve& solve_penalized, const Positions& b, const Positions& gaps,
                      Positions& multipliers, Positions& x) const {
  copy_rows(workers_, b, x);
  multipliers.array().colwise() *= beyond_penalties_;
  rows_.add_transposed((gaps.array().colwise() * penalties_).matrix() - multipliers, x, workers_);
  solve_penalized(x);
  Positions direction;
  rows_.multiply(x, direction, workers_);
  direction -= gaps + (multipliers.array().colwise() * compliance_).matrix();
  direction.array().colwise() *= scaling_;
  Positions residual = direction;  // scaled, as all of it
  Positions moved;                 // F^-1 H^T residual
  Positions product;               // S residual
  const auto respond = [&] {
    moved = Positions::Zero(x.rows(), 3);
    rows_.add_transposed(residual, moved, workers_);
    solve_penalized(moved);
    rows_.multiply(moved, product, workers_);
    product.array() += residual.array().colwise() * compliance_;
  };
  respond();
  Positions moved_along = moved;
  Positions product_along = product;
  Coefficients slope = dot(residual, product);
  const Coefficients enough = accuracy * accuracy * slope;
  for (int step = 0; step < kMostSteps; ++step) {
    const Positions scaled = (product_along.array().colwise() * scaling_).matrix();
    const Coefficients length = ratio(slope, dot(product_along, scaled));
    add_scaled(moved_along, -length, x, workers_);
    add_scaled(direction, length, multipliers, workers_);
    add_scaled(scaled, -length, residual, workers_);
    if (step + 1 == kMostSteps) break;
    respond();
    const Coefficients next_slope = dot(residual, product);
    if ((next_slope <= enough).all()) break;
    const Coefficients keep = ratio(next_slope, slope);
    scale_and_add(residual, keep, direction, workers_);
    scale_and_add(moved, keep, moved_along, workers_);
    scale_and_add(product, keep, product_along, workers_);
    slope = next_slope;
  }
  multipliers.array().colwise() /= beyond_penalties_;
}

}  // namespace arap
