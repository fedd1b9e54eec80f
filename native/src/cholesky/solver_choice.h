// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "arap/options.h"
#include "cholesky/linear_solver.h"
#include "kernels/tile_kernels.h"
#include "parallel/workers.h"

namespace arap {

/// @param pattern  symmetric, stored whole, with its diagonal
/// @param workers  of factorize() and of solves
/// @param format   of kBlockLdlt: halves suffice if the stiffness is about the same everywhere
[[nodiscard]] std::unique_ptr<LinearSolver> make_linear_solver(const SparseMatrix& pattern,
                                                               LinearSolverKind kind = LinearSolverKind::kBlockLdlt,
                                                               const Workers& workers = Workers(1),
                                                               TileFormat format = TileFormat::kHalf,
                                                               const MeterPart& meter = {});

}  // namespace arap
