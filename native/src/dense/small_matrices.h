// SPDX-License-Identifier: GPL-3.0-or-later
// Decompositions of matrices of a few rows. Eigen's are large templates, and each source that instantiates one takes
// seconds to compile: so they are instantiated here once, behind functions.
#pragma once

#include <Eigen/Core>

#include "arap/types.h"

namespace arap {

/// A = V diag(values) V^T.
struct SymmetricEigen3 {
  Vector3 values;   ///< ascending
  Matrix3 vectors;  ///< V: orthonormal columns
};
[[nodiscard]] SymmetricEigen3 symmetric_eigen(const Matrix3& A);
/// Its values alone, ascending.
[[nodiscard]] Vector3 symmetric_eigenvalues(const Matrix3& A);
/// The nearest positive semi-definite matrix. By closed formulas: faster, and less exact where eigenvalues are close.
[[nodiscard]] Matrix3 positive_part(const Matrix3& A);

/// The least-squares solution of A x = b, A symmetric; if A is singular, the shortest one.
[[nodiscard]] Vector3 solve_symmetric(const Matrix3& A, const Vector3& b);

/// A = U diag(values) V^T.
struct Svd3 {
  Vector3 values;  ///< descending, >= 0
  Matrix3 U;
  Matrix3 V;
};
[[nodiscard]] Svd3 svd(const Matrix3& A);

/// x of least length with A x = b, A symmetric.
/// @param threshold  of a pivot to the largest one; below, it counts as 0
[[nodiscard]] Eigen::Vector4d solve_shortest(const Eigen::Matrix4d& A, const Eigen::Vector4d& b, double threshold);

/// As SymmetricEigen3, of any size.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
[[nodiscard]] SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);

}  // namespace arap
