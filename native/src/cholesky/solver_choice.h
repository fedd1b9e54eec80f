// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "arap/options.h"
#include "cholesky/linear_solver.h"
#include "kernels/tile_kernels.h"
#include "parallel/workers.h"

namespace arap {

/// Makes solvers that stand in for BlockLdlt in a model: what tests and benchmarks compare it with.
class SolverFactory {
 public:
  SolverFactory() = default;
  SolverFactory(const SolverFactory&) = delete;
  SolverFactory& operator=(const SolverFactory&) = delete;
  virtual ~SolverFactory() = default;

  /// @param pattern  symmetric, stored whole, with its diagonal
  [[nodiscard]] virtual std::unique_ptr<LinearSolver> make(const SparseMatrix& pattern) const = 0;
};

/// @param pattern  symmetric, stored whole, with its diagonal
/// @param workers  of factorize() and of solves
/// @param format   of the factor: halves suffice if the stiffness is about the same everywhere
/// @param factory  makes another solver than BlockLdlt, or null
[[nodiscard]] std::unique_ptr<LinearSolver> make_linear_solver(const SparseMatrix& pattern,
                                                               const Workers& workers = Workers(1),
                                                               TileFormat format = TileFormat::kHalf,
                                                               const MeterPart& meter = {},
                                                               const SolverFactory* factory = nullptr);

}  // namespace arap
