// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/references/sparse_qr.h"

#include <Eigen/SparseQR>

#include "cholesky/references/kept_rows.h"
#include "cholesky/references/symmetric_ordering.h"

namespace arap {

namespace {

class QrFactorization final : public Factorization {
 public:
  QrFactorization(const SparseMatrix& A, const std::vector<char>& is_erased) : rows_(is_erased) {
    if (rows_.empty()) return;
    factor_.compute(rows_.of(A));
    if (factor_.info() != Eigen::Success || factor_.rank() < factor_.cols()) refuse_indefinite();
  }

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override {
    // Not by the factor's own solve, which notes its success in the factor: that would be a race between threads.
    rows_.solve(b, x, [&](const Eigen::MatrixX3d& right) {
      const Eigen::MatrixX3d y = factor_.matrixQ().adjoint() * right;
      const Eigen::MatrixX3d solution = factor_.matrixR().triangularView<Eigen::Upper>().solve(y);
      return Eigen::MatrixX3d(factor_.colsPermutation() * solution);
    });
  }

 private:
  KeptRows rows_;
  Eigen::SparseQR<SparseMatrix, SymmetricOrdering> factor_;
};

}  // namespace

std::unique_ptr<Factorization> SparseQr::factorize(const SparseMatrix& A, const std::vector<char>& is_erased) const {
  return std::make_unique<QrFactorization>(A, is_erased);
}

}  // namespace arap
