// SPDX-License-Identifier: GPL-3.0-or-later
#include "simplicial_ldlt.h"

#include <Eigen/SparseCholesky>
#include <utility>

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

class SimplicialFactorization final : public Factorization {
 public:
  SimplicialFactorization(const SparseMatrix& A, std::vector<int> kept) : kept_(std::move(kept)) {
    if (kept_.empty()) return;
    factor_.compute(lower_triangle(A, kept_));
    const bool is_definite = factor_.info() == Eigen::Success && (factor_.vectorD().array() > 0).all();
    if (!is_definite)
      throw SolverError("the system is not positive definite; look for parts of the mesh without stiffness");
  }

  void solve(Positions& b) const override {
    if (kept_.empty()) {
      b.setZero();
      return;
    }
    const Eigen::MatrixX3d x = factor_.solve(Eigen::MatrixX3d(b(kept_, Eigen::all)));
    b.setZero();
    b(kept_, Eigen::all) = x;
  }

 private:
  std::vector<int> kept_;  ///< the rows of A that are left
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> factor_;
};

}  // namespace

std::unique_ptr<Factorization> SimplicialLdlt::factorize(const SparseMatrix& A,
                                                         const std::vector<char>& is_erased) const {
  std::vector<int> kept;
  for (int i = 0; i < static_cast<int>(A.rows()); ++i)
    if (is_erased[i] == 0) kept.push_back(i);
  return std::make_unique<SimplicialFactorization>(A, std::move(kept));
}

}  // namespace arap
