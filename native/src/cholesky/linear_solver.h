// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "arap/error.h"
#include "arap/types.h"
#include "base/format_message.h"
#include "sparse/sparse.h"

namespace arap {

/// A factorized symmetric positive definite matrix.
class Factorization {
 public:
  Factorization() = default;
  Factorization(const Factorization&) = delete;
  Factorization& operator=(const Factorization&) = delete;
  virtual ~Factorization() = default;

  /// Sets x (n, 3) to the solution, erased rows to 0; x may be b. The solution may be that of a nearby matrix,
  /// symmetric and positive definite too, whose difference shows from the third digit on. So iterate x += solve(b - A
  /// x), which ends at the exact x, or use solve_with_cg.
  virtual void solve(const Positions& b, Positions& x) const = 0;
  void solve(Positions& x) const { solve(x, x); }

  /// Of the factor; a solve reads it twice. 0 where the solver does not say.
  [[nodiscard]] virtual size_t bytes() const { return 0; }
};

/// A direct solver for matrices of one pattern. What depends on the pattern alone is done once, at construction; it
/// serves every choice of values and of erased rows.
class LinearSolver {
 public:
  LinearSolver() = default;
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  virtual ~LinearSolver() = default;

  /// Factorizes A, stored whole, without the erased rows and columns. Throws SolverError where what is left is not
  /// positive definite.
  [[nodiscard]] virtual std::unique_ptr<Factorization> factorize(const SparseMatrix& A,
                                                                 const std::vector<char>& is_erased) const = 0;

  /// The order in which this solver goes through the unknowns, order()[new] = old, or null if it has none. A model that
  /// numbers its unknowns so from the start spares every solve the way there and back.
  [[nodiscard]] virtual const std::vector<int>* order() const { return nullptr; }

  /// From now on matrices and vectors are numbered in order(), which becomes null. Existing factorizations keep their
  /// numbering.
  /// @param pattern  the solver's, numbered so: entry (i, j) was (order[i], order[j])
  /// Throws SolverError where it is another one.
  virtual void renumber(const SparseMatrix& pattern) { static_cast<void>(pattern); }
};

/// Throws the SolverError of an entry that is not finite.
[[noreturn]] inline void throw_not_finite(Eigen::Index row, Eigen::Index column, double value) {
  throw SolverError(text("entry (", row, ", ", column, ") of the system is ", value,
                         "; look for positions, weights and stiffnesses that are not finite"));
}

/// Throws the SolverError of a matrix that is not positive definite.
[[noreturn]] inline void throw_not_positive_definite() {
  throw SolverError("the system is not positive definite; look for parts of the mesh without stiffness");
}

}  // namespace arap
