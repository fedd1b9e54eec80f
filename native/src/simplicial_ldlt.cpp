// SPDX-License-Identifier: GPL-3.0-or-later
#include "simplicial_ldlt.h"

#include "arap/error.h"

namespace arap {

namespace {

/// The lower triangle of the rows and columns `kept`.
SparseMatrix lower_triangle(const SparseMatrix& A, const std::vector<int>& kept) {
  std::vector<int> new_index(A.rows(), -1);
  for (size_t k = 0; k < kept.size(); ++k) new_index[kept[k]] = static_cast<int>(k);
  SparseMatrix result(kept.size(), kept.size());
  result.reserve((A.nonZeros() + A.rows()) / 2);
  for (size_t k = 0; k < kept.size(); ++k) {
    result.startVec(k);
    for (SparseMatrix::InnerIterator it(A, kept[k]); it; ++it) {
      const int row = new_index[it.row()];
      if (row >= static_cast<int>(k)) result.insertBack(row, k) = it.value();
    }
  }
  result.finalize();
  return result;
}

}  // namespace

void SimplicialLdlt::factorize(const SparseMatrix& A, const std::vector<char>& is_erased) {
  kept_.clear();
  for (int i = 0; i < static_cast<int>(A.rows()); ++i)
    if (is_erased[i] == 0) kept_.push_back(i);
  if (kept_.empty()) return;
  factor_.compute(lower_triangle(A, kept_));
  const bool is_definite = factor_.info() == Eigen::Success && factor_.vectorD().minCoeff() > 0;
  if (!is_definite)
    throw SolverError("the system is not positive definite; look for parts of the mesh without stiffness");
}

void SimplicialLdlt::solve(Positions& b) const {
  if (kept_.empty()) {
    b.setZero();
    return;
  }
  Eigen::MatrixX3d kept_b(kept_.size(), 3);
  for (size_t k = 0; k < kept_.size(); ++k) kept_b.row(k) = b.row(kept_[k]);
  const Eigen::MatrixX3d x = factor_.solve(kept_b);
  b.setZero();
  for (size_t k = 0; k < kept_.size(); ++k) b.row(kept_[k]) = x.row(k);
}

std::unique_ptr<LinearSolver> make_linear_solver() { return std::make_unique<SimplicialLdlt>(); }

}  // namespace arap
