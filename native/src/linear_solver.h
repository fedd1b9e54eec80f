// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "arap/types.h"
#include "sparse.h"

namespace arap {

/// A direct solver of A x = b for a symmetric positive definite A with some rows and columns erased, for three
/// right-hand sides at once.
class LinearSolver {
 public:
  LinearSolver() = default;
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  virtual ~LinearSolver() = default;

  /// Factorizes A, stored whole, without the erased rows and columns. Throws SolverError where what is left is not
  /// positive definite.
  virtual void factorize(const SparseMatrix& A, const std::vector<char>& is_erased) = 0;

  /// Replaces b (n, 3) by the solution; erased rows become 0. May be called from several threads.
  virtual void solve(Positions& b) const = 0;
};

[[nodiscard]] std::unique_ptr<LinearSolver> make_linear_solver();

}  // namespace arap
