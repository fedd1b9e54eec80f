// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cholesky/linear_solver.h"

namespace arap {

/// Eigen's stabilized biconjugate gradients with an incomplete LU factorization as preconditioner: the one iterative
/// solver, with the least memory. A solve ends at a residual of kTolerance of its right-hand side and throws
/// SolverError where it does not get there. An indefinite matrix whose diagonal is positive is not told from one that
/// is hard to solve.
class BiCgStab final : public LinearSolver {
 public:
  static constexpr double kTolerance = 1e-10;

  [[nodiscard]] std::unique_ptr<Factorization> factorize(const SparseMatrix& A,
                                                         const std::vector<char>& is_erased) const override;
};

}  // namespace arap
