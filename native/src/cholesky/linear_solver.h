// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "arap/error.h"
#include "arap/types.h"
#include "base/format_message.h"
#include "parallel/meter.h"
#include "sparse/sparse.h"

namespace arap {

/// A matrix that a factorization cannot be of. Of a class of its own, for who has another matrix to try.
class NotPositiveDefinite : public SolverError {
 public:
  using SolverError::SolverError;
};

/// Columns C beside a factorized matrix M: solutions x = M^-1 (b - C y), with y chosen by what x would be without. It
/// refers to the factorization. The M of all its products is the one of solve(), rounded as that is. A column with few
/// entries takes a small part of a solve to make, to use and to keep.
class Border {
 public:
  /// y, (n_columns, 3), for C^T M^-1 b.
  using Choose = std::function<Eigen::MatrixX3d(const Eigen::MatrixX3d& products)>;

  Border() = default;
  Border(const Border&) = delete;
  Border& operator=(const Border&) = delete;
  virtual ~Border() = default;

  /// C^T M^-1 C.
  [[nodiscard]] virtual Eigen::MatrixXd products() const = 0;

  /// Replaces b (n, 3) by x, 0 at erased rows.
  virtual void solve(const Choose& choose, Positions& x) const = 0;
};

/// A factorized symmetric positive definite matrix.
class Factorization {
 public:
  Factorization() = default;
  Factorization(const Factorization&) = delete;
  Factorization& operator=(const Factorization&) = delete;
  virtual ~Factorization() = default;

  /// Sets x (n, 3) to the solution and erased rows to 0; x may be b. The solution may be that of a nearby symmetric
  /// positive definite matrix, right to three digits. For the exact x iterate x += solve(b - A x) or use solve_with_cg.
  virtual void solve(const Positions& b, Positions& x) const = 0;
  void solve(Positions& x) const { solve(x, x); }

  /// @param columns  (n, n_columns), with few entries each, none in erased rows
  [[nodiscard]] virtual std::unique_ptr<Border> border(const SparseMatrix& columns,
                                                       const MeterPart& meter = {}) const = 0;

  /// Size of the factor, which a solve reads twice; 0 if unknown.
  [[nodiscard]] virtual size_t bytes() const { return 0; }
};

/// A solver for matrices of one pattern. What depends on the pattern alone is computed once, at construction, and used
/// for all values and all sets of erased rows.
class LinearSolver {
 public:
  LinearSolver() = default;
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  virtual ~LinearSolver() = default;

  /// Factorizes A, stored whole, without the erased rows and columns. Throws NotPositiveDefinite if the rest is not,
  /// SolverError if an entry is not finite.
  [[nodiscard]] virtual std::unique_ptr<Factorization> factorize(const SparseMatrix& A,
                                                                 const std::vector<char>& is_erased,
                                                                 const MeterPart& meter = {}) const = 0;

  /// The solver's ordering of the unknowns, ordering()[new] = old, or null if it has none. A model that numbers its
  /// unknowns this way saves every solve a permutation of its input and output.
  [[nodiscard]] virtual const std::vector<int>* ordering() const { return nullptr; }

  /// Expects all later matrices and vectors to be permuted by ordering(), which becomes null. Existing factorizations
  /// keep their numbering.
  /// @param pattern  the solver's pattern, permuted: entry (i, j) was (ordering[i], ordering[j])
  /// Throws SolverError if it is another pattern.
  virtual void renumber(const SparseMatrix& pattern) { static_cast<void>(pattern); }
};

/// Throws the SolverError of an entry that is not finite.
[[noreturn]] inline void throw_not_finite(Eigen::Index row, Eigen::Index column, double value) {
  throw SolverError(text("entry (", row, ", ", column, ") of the system is ", value,
                         "; look for positions, weights and stiffnesses that are not finite"));
}

[[noreturn]] inline void throw_not_positive_definite() {
  throw NotPositiveDefinite("the system is not positive definite; look for parts of the mesh without stiffness");
}

}  // namespace arap
