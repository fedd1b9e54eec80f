// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "base/eigen_compat.h"
#include "sparse/sparse.h"

namespace arap {

/// What is left of a symmetric system where some rows and columns are erased, for the solvers that want a matrix
/// without them.
class KeptRows {
 public:
  explicit KeptRows(const std::vector<char>& is_erased);

  [[nodiscard]] bool empty() const { return kept_.empty(); }

  /// A, stored whole, without the erased rows and columns. Throws SolverError where that cannot be positive definite:
  /// an entry is not finite, or one of the diagonal not above 0.
  [[nodiscard]] SparseMatrix of(const SparseMatrix& A) const;

  /// Sets the kept rows of x to solve(those of b), erased ones to 0; x may be b.
  template <class Solve>
  void solve(const Positions& b, Positions& x, const Solve& solve) const {
    Eigen::MatrixX3d kept(kept_.size(), 3);
    if (!kept_.empty()) kept = solve(Eigen::MatrixX3d(b(kept_, all)));
    x.setZero(b.rows(), 3);
    x(kept_, all) = kept;
  }

 private:
  std::vector<int> kept_;       ///< the rows that are left
  std::vector<int> new_index_;  ///< of each row among those, -1 = erased
};

/// Throws the SolverError of an entry that is not finite.
[[noreturn]] void refuse_entry(Eigen::Index row, Eigen::Index column, double value);

/// Throws the SolverError of a matrix that is not positive definite.
[[noreturn]] void refuse_indefinite();

}  // namespace arap
