// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cholesky/linear_solver.h"

namespace arap {

/// Eigen's supernodal LU factorization, which knows nothing of symmetry: twice the numbers of a Cholesky factor. It is
/// told to pivot on the diagonal, which is stable for a positive definite matrix and keeps the symmetric ordering; the
/// pivots then are positive exactly where the matrix is positive definite.
class SparseLu final : public LinearSolver {
 public:
  [[nodiscard]] std::unique_ptr<Factorization> factorize(const SparseMatrix& A,
                                                         const std::vector<char>& is_erased) const override;
};

}  // namespace arap
