// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

namespace arap {

/// Solves a small dense symmetric system, in the least-squares sense if it is singular: then for the smallest solution.
class LeastSquares {
 public:
  LeastSquares();
  ~LeastSquares();
  LeastSquares(LeastSquares&&) noexcept;
  LeastSquares& operator=(LeastSquares&&) noexcept;

  void compute(const Eigen::MatrixXd& matrix);
  [[nodiscard]] Eigen::MatrixX3d solve(const Eigen::MatrixX3d& right) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

/// The factor L D L^T of a dense symmetric positive semi-definite matrix.
class DenseLdlt {
 public:
  DenseLdlt();
  ~DenseLdlt();
  DenseLdlt(DenseLdlt&&) noexcept;
  DenseLdlt& operator=(DenseLdlt&&) noexcept;

  void compute(const Eigen::MatrixXd& matrix);
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

/// Columns of a matrix, those first that are farthest from the span of the ones before them.
struct PivotedColumns {
  Eigen::VectorXi order;
  int rank = 0;  ///< the columns that count
};

/// @param threshold  of a pivot to the largest one; below, a column does not count
[[nodiscard]] PivotedColumns pivot_columns(const Eigen::MatrixXd& matrix, double threshold);

}  // namespace arap
