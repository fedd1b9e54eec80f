// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/solver_choice.h"

#include "cholesky/block_ldlt.h"
#include "cholesky/references/eigen_solvers.h"

namespace arap {

std::unique_ptr<LinearSolver> make_linear_solver(const SparseMatrix& pattern, LinearSolverKind kind,
                                                 const Workers& workers, TileFormat format, const MeterPart& meter) {
  if (kind == LinearSolverKind::kBlockLdlt)
    return std::make_unique<BlockLdlt>(pattern, workers, choose_isa(), format, meter);
  return make_eigen_solver(kind);
}

}  // namespace arap
