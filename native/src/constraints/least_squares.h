// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>

namespace arap {

/// Solves a small dense symmetric system, in the least-squares sense if it is singular: then for the smallest solution.
class LeastSquares {
 public:
  void compute(const Eigen::MatrixXd& matrix) {
    if (matrix.rows() == 0) return;
    lu_.compute(matrix);
    // The estimate is none if a pivot is 0.
    const Eigen::ArrayXd pivots = lu_.matrixLU().diagonal().array().abs();
    is_regular_ = pivots.minCoeff() > kSingular * pivots.maxCoeff() && lu_.rcond() > kSingular;
    if (is_regular_) return;
    decomposition_.setThreshold(kSingular);
    decomposition_.compute(matrix);
  }

  [[nodiscard]] Eigen::MatrixX3d solve(const Eigen::MatrixX3d& right) const {
    if (right.rows() == 0) return right;
    if (is_regular_) return lu_.solve(right);
    return decomposition_.solve(right);
  }

 private:
  static constexpr double kSingular = 1e-12;

  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;  ///< many times as fast as the other
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition_;
  bool is_regular_ = false;
};

}  // namespace arap
