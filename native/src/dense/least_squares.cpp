// SPDX-License-Identifier: GPL-3.0-or-later
#include "dense/least_squares.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

#include "dense/singular.h"

namespace arap {

struct LeastSquares::Factors {
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;  ///< many times as fast as the other
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  bool is_regular = false;
};

LeastSquares::LeastSquares() : factors_(std::make_unique<Factors>()) {}
LeastSquares::~LeastSquares() = default;
LeastSquares::LeastSquares(LeastSquares&&) noexcept = default;
LeastSquares& LeastSquares::operator=(LeastSquares&&) noexcept = default;

void LeastSquares::compute(const Eigen::MatrixXd& matrix) {
  if (matrix.rows() == 0) return;
  auto& [lu, decomposition, is_regular] = *factors_;
  lu.compute(matrix);
  // The estimate is none if a pivot is 0.
  const Eigen::ArrayXd pivots = lu.matrixLU().diagonal().array().abs();
  is_regular = pivots.minCoeff() > kSingular * pivots.maxCoeff() && lu.rcond() > kSingular;
  if (is_regular) return;
  decomposition.setThreshold(kSingular);
  decomposition.compute(matrix);
}

Eigen::MatrixX3d LeastSquares::solve(const Eigen::MatrixX3d& right) const {
  if (right.rows() == 0) return right;
  if (factors_->is_regular) return factors_->lu.solve(right);
  return factors_->decomposition.solve(right);
}

struct DenseLdlt::Factor {
  Eigen::LDLT<Eigen::MatrixXd> ldlt;
};

DenseLdlt::DenseLdlt() : factor_(std::make_unique<Factor>()) {}
DenseLdlt::~DenseLdlt() = default;
DenseLdlt::DenseLdlt(DenseLdlt&&) noexcept = default;
DenseLdlt& DenseLdlt::operator=(DenseLdlt&&) noexcept = default;

void DenseLdlt::compute(const Eigen::MatrixXd& matrix) { factor_->ldlt.compute(matrix); }

Eigen::MatrixXd DenseLdlt::solve(const Eigen::MatrixXd& right) const { return factor_->ldlt.solve(right); }

PivotedColumns pivot_columns(const Eigen::MatrixXd& matrix, double threshold) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(matrix);
  qr.setThreshold(threshold);
  return {qr.colsPermutation().indices(), static_cast<int>(qr.rank())};
}

}  // namespace arap
