// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/references/sparse_lu.h"

#include <Eigen/SparseLU>

#include "cholesky/references/kept_rows.h"
#include "cholesky/references/symmetric_ordering.h"

namespace arap {

namespace {

/// SparseLU with the pivots on the diagonal, and a look at them, which Eigen has for its determinants only.
class DiagonalPivotLu : public Eigen::SparseLU<SparseMatrix, SymmetricOrdering> {
 public:
  DiagonalPivotLu() {
    isSymmetric(true);
    setPivotThreshold(0);
  }

  [[nodiscard]] bool has_positive_pivots() const {
    // Where a pivot on the diagonal was 0, it took one beside it.
    if (rowsPermutation().indices() != colsPermutation().indices()) return false;
    for (Eigen::Index j = 0; j < cols(); ++j)
      for (SCMatrix::InnerIterator it(m_Lstore, j); it; ++it)
        if (it.index() == j && !(it.value() > 0)) return false;
    return true;
  }
};

class LuFactorization final : public Factorization {
 public:
  LuFactorization(const SparseMatrix& A, const std::vector<char>& is_erased) : rows_(is_erased) {
    if (rows_.empty()) return;
    factor_.compute(rows_.of(A));
    if (factor_.info() != Eigen::Success || !factor_.has_positive_pivots()) refuse_indefinite();
  }

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override {
    rows_.solve(b, x, [&](const Eigen::MatrixX3d& right) { return factor_.solve(right).eval(); });
  }

 private:
  KeptRows rows_;
  DiagonalPivotLu factor_;
};

}  // namespace

std::unique_ptr<Factorization> SparseLu::factorize(const SparseMatrix& A, const std::vector<char>& is_erased) const {
  return std::make_unique<LuFactorization>(A, is_erased);
}

}  // namespace arap
