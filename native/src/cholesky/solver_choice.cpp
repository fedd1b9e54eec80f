// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/solver_choice.h"

#include "cholesky/block_ldlt.h"

namespace arap {

std::unique_ptr<LinearSolver> make_linear_solver(const SparseMatrix& pattern, const Workers& workers, TileFormat format,
                                                 const MeterPart& meter, const SolverFactory* factory) {
  if (factory != nullptr) return factory->make(pattern);
  return std::make_unique<BlockLdlt>(pattern, workers, choose_isa(), format, meter);
}

}  // namespace arap
