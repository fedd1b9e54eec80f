// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cholesky/solver_choice.h"

namespace arap {

/// Eigen's sparse solvers, in double and one thread, which BlockLdlt is compared with. They order the unknowns by
/// approximate minimum degree, again for each set of erased rows.
///   kSimplicialLdlt  Cholesky L D L^T, column by column.
///   kSparseLu        Supernodal LU with the pivots on the diagonal. Ignores the symmetry: twice the numbers.
///   kSparseQr        Householder QR. Far more fill and work: seconds at 3,000 unknowns of a mesh, a minute at 10,000.
///   kBiCgStab        Stabilized biconjugate gradients, preconditioned by an incomplete LU factorization. The only
///                    iterative one and the least memory. solve() stops at a relative residual of 1e-10 and throws
///                    SolverError if it does not get there.
/// QR and BiCGSTAB do not notice an indefinite matrix whose diagonal is positive.
enum class ReferenceSolver { kSimplicialLdlt, kSparseLu, kSparseQr, kBiCgStab };

/// Lives as long as the program does.
[[nodiscard]] const SolverFactory& reference_solver(ReferenceSolver kind);

}  // namespace arap
