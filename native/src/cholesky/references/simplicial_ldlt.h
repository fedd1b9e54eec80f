// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cholesky/linear_solver.h"

namespace arap {

/// Eigen's sparse Cholesky factorization L D L^T, column by column, with approximate minimum degree ordering, which it
/// finds anew for each set of erased rows.
class SimplicialLdlt final : public LinearSolver {
 public:
  [[nodiscard]] std::unique_ptr<Factorization> factorize(const SparseMatrix& A,
                                                         const std::vector<char>& is_erased) const override;
};

}  // namespace arap
