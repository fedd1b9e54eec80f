// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/stiff_rows.h"

#include <utility>

#include "parallel/parallel.h"

namespace arap {

namespace {

/// Ends when the gaps that are left are this part of those that a step began with.
constexpr double kAccuracy = 0.03;
constexpr int kMostSteps = 20;

/// The three right-hand sides have coefficients of their own.
using Coefficients = Eigen::Array<double, 1, 3>;

Coefficients dot(const Positions& a, const Positions& b) { return a.cwiseProduct(b).colwise().sum().array(); }

/// a / b, 0 if there is nothing left to divide.
Coefficients ratio(const Coefficients& a, const Coefficients& b) { return (b > 0).select(a / b, Coefficients::Zero()); }

/// x += y * diag(a)
void add_scaled(const Positions& y, const Coefficients& a, Positions& x, const Workers& workers) {
  parallel_for<2048>(workers, static_cast<int>(x.rows()), [&](int begin, int end) {
    x.middleRows(begin, end - begin).array() += y.middleRows(begin, end - begin).array().rowwise() * a;
  });
}

}  // namespace

StiffRows::StiffRows(std::unique_ptr<Factorization> factor, const RowMatrix& rows, Eigen::VectorXd weights,
                     Eigen::VectorXd penalties, Workers workers)
    : factor_(std::move(factor)),
      rows_(rows),
      compliance_(1 / (weights - penalties).array()),
      scaling_(1 / (1 / penalties.array() + compliance_)),
      workers_(std::move(workers)) {}

// With x = F^-1 (b - H^T f), F the factorized matrix, the forces f = (w - p) H x solve
//     (H F^-1 H^T + 1 / (w - p)) f = H F^-1 b.
void StiffRows::solve(const Positions& b, Positions& x) const {
  factor_->solve(b, x);
  Positions residual;
  rows_.multiply(x, residual, workers_);
  Positions direction = (residual.array().colwise() * scaling_).matrix();
  Coefficients slope = dot(residual, direction);
  const Coefficients enough = kAccuracy * kAccuracy * slope;
  Positions moved;  // F^-1 H^T direction
  Positions product;
  for (int step = 0; step < kMostSteps && (slope > enough).any(); ++step) {
    moved = Positions::Zero(x.rows(), 3);
    rows_.add_transposed(direction, moved, workers_);
    factor_->solve(moved);
    rows_.multiply(moved, product, workers_);
    product.array() += direction.array().colwise() * compliance_;
    const Coefficients length = ratio(slope, dot(direction, product));
    add_scaled(moved, -length, x, workers_);
    add_scaled(product, -length, residual, workers_);
    const Positions scaled = (residual.array().colwise() * scaling_).matrix();
    const Coefficients next_slope = dot(residual, scaled);
    direction = scaled + (direction.array().rowwise() * ratio(next_slope, slope)).matrix();
    slope = next_slope;
  }
}

}  // namespace arap
