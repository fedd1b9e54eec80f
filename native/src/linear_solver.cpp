// SPDX-License-Identifier: GPL-3.0-or-later
#include "linear_solver.h"

#include "block_ldlt.h"
#include "simplicial_ldlt.h"

namespace arap {

std::unique_ptr<LinearSolver> make_linear_solver(const SparseMatrix& pattern, LinearSolverKind kind, int threads) {
  if (kind == LinearSolverKind::kSimplicialLdlt) return std::make_unique<SimplicialLdlt>();
  return std::make_unique<BlockLdlt>(pattern, threads);
}

}  // namespace arap
