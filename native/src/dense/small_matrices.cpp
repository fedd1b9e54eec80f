// SPDX-License-Identifier: GPL-3.0-or-later
#include "dense/small_matrices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "dense/singular.h"

namespace arap {

SymmetricEigen3 symmetric_eigen(const Matrix3& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Vector3 symmetric_eigenvalues(const Matrix3& A) {
  return Eigen::SelfAdjointEigenSolver<Matrix3>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Matrix3 positive_part(const Matrix3& A) {
  Eigen::SelfAdjointEigenSolver<Matrix3> solver;
  solver.computeDirect(A);
  const Matrix3& axes = solver.eigenvectors();
  return axes * solver.eigenvalues().cwiseMax(0).asDiagonal() * axes.transpose();
}

Vector3 solve_symmetric(const Matrix3& A, const Vector3& b) {
  const auto [values, vectors] = symmetric_eigen(A);
  const double least = kSingular * values.cwiseAbs().maxCoeff();
  Vector3 x = Vector3::Zero();
  for (int k = 0; k < 3; ++k)
    if (std::abs(values[k]) > least) x += vectors.col(k) * (vectors.col(k).dot(b) / values[k]);
  return x;
}

Svd3 svd(const Matrix3& A) {
  const Eigen::JacobiSVD<Matrix3> solver(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {solver.singularValues(), solver.matrixU(), solver.matrixV()};
}

Eigen::Vector4d solve_shortest(const Eigen::Matrix4d& A, const Eigen::Vector4d& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix4d> solver;
  solver.setThreshold(threshold);
  solver.compute(A);
  return solver.solve(b);
}

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace arap
