// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "arap/types.h"
#include "parallel/workers.h"

namespace arap {

/// Symmetric matrices are stored whole: a column is also a row.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// P A P^T: row and column ordering[k] of A become k; new_of_old is the inverse of ordering.
[[nodiscard]] SparseMatrix renumbered(const SparseMatrix& A, const std::vector<int>& ordering,
                                      const std::vector<int>& new_of_old, int threads);

/// result = A x for a symmetric A stored whole; (n, 3).
void multiply(const SparseMatrix& A, const Positions& x, Positions& result, const Workers& workers);

/// Connected components of a symmetric matrix, coupled by entries other than 0: the lowest unknown of each unknown's
/// component.
[[nodiscard]] std::vector<int> connected_components(const SparseMatrix& A);

}  // namespace arap
