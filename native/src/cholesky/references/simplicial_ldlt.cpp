// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/references/simplicial_ldlt.h"

#include <Eigen/SparseCholesky>

#include "cholesky/references/kept_rows.h"

namespace arap {

namespace {

class SimplicialFactorization final : public Factorization {
 public:
  SimplicialFactorization(const SparseMatrix& A, const std::vector<char>& is_erased) : rows_(is_erased) {
    if (rows_.empty()) return;
    factor_.compute(rows_.of(A));
    const bool is_definite = factor_.info() == Eigen::Success && (factor_.vectorD().array() > 0).all();
    if (!is_definite) refuse_indefinite();
  }

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override {
    rows_.solve(b, x, [&](const Eigen::MatrixX3d& right) { return factor_.solve(right).eval(); });
  }

 private:
  KeptRows rows_;
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> factor_;
};

}  // namespace

std::unique_ptr<Factorization> SimplicialLdlt::factorize(const SparseMatrix& A,
                                                         const std::vector<char>& is_erased) const {
  return std::make_unique<SimplicialFactorization>(A, is_erased);
}

}  // namespace arap
