// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/dense.h"

#include <Eigen/LU>
#include <Eigen/QR>

namespace arap_test {

using Eigen::MatrixXd;

std::function<MatrixXd(const MatrixXd&)> solver_of(const MatrixXd& A) {
  if (A.rows() == 0) return [](const MatrixXd& b) { return b; };  // Eigen does not factorize it
  return [lu = Eigen::FullPivLU<MatrixXd>(A)](const MatrixXd& b) { return lu.solve(b).eval(); };
}

MatrixXd least_squares(const MatrixXd& A, const MatrixXd& b) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A).solve(b);
}

}  // namespace arap_test
