// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/solver_choice.h"

#include "cholesky/block_ldlt.h"
#include "cholesky/references/bicgstab.h"
#include "cholesky/references/simplicial_ldlt.h"
#include "cholesky/references/sparse_lu.h"
#include "cholesky/references/sparse_qr.h"

namespace arap {

std::unique_ptr<LinearSolver> make_linear_solver(const SparseMatrix& pattern, LinearSolverKind kind,
                                                 const Workers& workers, TileFormat format) {
  switch (kind) {
    case LinearSolverKind::kBlockLdlt:
      break;
    case LinearSolverKind::kSimplicialLdlt:
      return std::make_unique<SimplicialLdlt>();
    case LinearSolverKind::kSparseLu:
      return std::make_unique<SparseLu>();
    case LinearSolverKind::kSparseQr:
      return std::make_unique<SparseQr>();
    case LinearSolverKind::kBiCgStab:
      return std::make_unique<BiCgStab>();
  }
  return std::make_unique<BlockLdlt>(pattern, workers, choose_isa(), format);
}

}  // namespace arap
