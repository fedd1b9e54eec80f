// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cholesky/linear_solver.h"

namespace arap {

/// Eigen's Householder QR factorization, column by column: it needs no symmetry and no definiteness, and pays for it
/// with far more fill and work, seconds at three thousand unknowns of a mesh and a minute at ten thousand: for
/// comparisons on small ones. It tells a singular matrix, but not an indefinite one whose diagonal is positive.
class SparseQr final : public LinearSolver {
 public:
  [[nodiscard]] std::unique_ptr<Factorization> factorize(const SparseMatrix& A,
                                                         const std::vector<char>& is_erased) const override;
};

}  // namespace arap
