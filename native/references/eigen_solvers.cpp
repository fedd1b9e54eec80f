// SPDX-License-Identifier: GPL-3.0-or-later
#include "references/eigen_solvers.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <vector>

#include "arap/error.h"
#include "base/eigen_compat.h"
#include "base/format_message.h"

namespace arap {

namespace {

using RightSides = Eigen::MatrixX3d;

// Each solver has
//   bool compute(A): false if A is not positive definite, as far as the solver can tell
//   RightSides solve(b) const: may run on several threads at once

class SimplicialLdlt {
 public:
  bool compute(const SparseMatrix& A) {
    factor_.compute(A);
    return factor_.info() == Eigen::Success && (factor_.vectorD().array() > 0).all();
  }
  [[nodiscard]] RightSides solve(const RightSides& b) const { return factor_.solve(b); }

 private:
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> factor_;
};

/// Minimum degree for Eigen's general factorizations. Their default, COLAMD, ignores the symmetry and gives twice the
/// fill; Eigen's AMDOrdering returns the inverse of the permutation that they expect.
struct SymmetricOrdering {
  using PermutationType = Eigen::AMDOrdering<int>::PermutationType;

  void operator()(const SparseMatrix& A, PermutationType& permutation) const {
    PermutationType inverse;
    Eigen::AMDOrdering<int>()(A, inverse);
    permutation = inverse.inverse();
  }
};

/// Pivots on the diagonal are stable for a positive definite matrix and keep the symmetric ordering. They are all
/// positive exactly if the matrix is positive definite.
class SparseLu : private Eigen::SparseLU<SparseMatrix, SymmetricOrdering> {
 public:
  SparseLu() {
    isSymmetric(true);
    setPivotThreshold(0);
  }

  bool compute(const SparseMatrix& A) {
    SparseLU::compute(A);
    return info() == Eigen::Success && has_positive_pivots();
  }
  [[nodiscard]] RightSides solve(const RightSides& b) const { return SparseLU::solve(b); }

 private:
  [[nodiscard]] bool has_positive_pivots() const {
    // Eigen replaces a diagonal pivot of 0 by one beside it.
    if (rowsPermutation().indices() != colsPermutation().indices()) return false;
    for (Eigen::Index j = 0; j < cols(); ++j)
      for (SCMatrix::InnerIterator it(m_Lstore, j); it; ++it)
        if (it.index() == j && !(it.value() > 0)) return false;
    return true;
  }
};

class SparseQr {
 public:
  bool compute(const SparseMatrix& A) {
    factor_.compute(A);
    return factor_.info() == Eigen::Success && factor_.rank() == factor_.cols();
  }
  [[nodiscard]] RightSides solve(const RightSides& b) const {
    // SparseQR::solve() writes its status to the factor: a race between threads.
    const RightSides y = factor_.matrixQ().adjoint() * b;
    const RightSides x = factor_.matrixR().triangularView<Eigen::Upper>().solve(y);
    return factor_.colsPermutation() * x;
  }

 private:
  Eigen::SparseQR<SparseMatrix, SymmetricOrdering> factor_;
};

class BiCgStab {
 public:
  bool compute(const SparseMatrix& A) {
    matrix_ = A;
    iteration_.setTolerance(kTolerance);
    iteration_.setMaxIterations(2000);
    iteration_.preconditioner().setDroptol(1e-3);
    iteration_.preconditioner().setFillfactor(10);
    iteration_.compute(matrix_);
    return iteration_.info() == Eigen::Success;
  }
  [[nodiscard]] RightSides solve(const RightSides& b) const {
    RightSides x(b.rows(), 3);
    for (Eigen::Index c = 0; c < 3; ++c) x.col(c) = solve_column(b.col(c));
    return x;
  }

 private:
  static constexpr double kTolerance = 1e-10;

  [[nodiscard]] Eigen::VectorXd solve_column(const Eigen::VectorXd& b) const {
    // Normalized: squares of the residuals near the end of a solve would underflow.
    const double length = b.stableNorm();
    if (length == 0) return b;
    const std::scoped_lock one_at_a_time(busy_);  // Eigen writes its status to the object
    const Eigen::VectorXd x = iteration_.solve(b / length);
    if (iteration_.info() != Eigen::Success)
      throw SolverError(text("BiCGSTAB did not converge: residual ", iteration_.error(), " after ",
                             iteration_.iterations(), " iterations, wanted ", kTolerance, "; choose another solver"));
    return length * x;
  }

  SparseMatrix matrix_;  ///< the iteration refers to it
  Eigen::BiCGSTAB<SparseMatrix, Eigen::IncompleteLUT<double>> iteration_;
  mutable std::mutex busy_;
};

/// By two solves.
class SolvedBorder final : public Border {
 public:
  SolvedBorder(const Factorization& factor, const SparseMatrix& columns) : factor_(factor), columns_(columns) {}

  [[nodiscard]] Eigen::MatrixXd products() const override {
    Eigen::MatrixXd result(columns_.cols(), columns_.cols());
    for (Eigen::Index first = 0; first < columns_.cols(); first += 3) {
      const Eigen::Index n = std::min<Eigen::Index>(3, columns_.cols() - first);
      Positions x = Positions::Zero(columns_.rows(), 3);
      x.leftCols(n) = columns_.middleCols(first, n);
      factor_.solve(x);
      result.middleCols(first, n) = columns_.transpose() * x.leftCols(n);
    }
    return result;
  }

  void solve(const Choose& choose, Positions& x) const override {
    Positions free;
    factor_.solve(x, free);
    x -= columns_ * choose(columns_.transpose() * free);
    factor_.solve(x);
  }

 private:
  const Factorization& factor_;
  SparseMatrix columns_;
};

/// Solves with the matrix of the rows and columns that are not erased.
template <class Solver>
class EigenFactorization final : public Factorization {
 public:
  EigenFactorization(const SparseMatrix& A, const std::vector<char>& is_erased) {
    for (size_t i = 0; i < is_erased.size(); ++i)
      if (is_erased[i] == 0) kept_.push_back(static_cast<int>(i));
    if (!kept_.empty() && !solver_.compute(kept_of(A))) throw_not_positive_definite();
  }

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override {
    RightSides kept(kept_.size(), 3);
    if (!kept_.empty()) kept = solver_.solve(b(kept_, all));
    x.setZero(b.rows(), 3);
    x(kept_, all) = kept;
  }
  [[nodiscard]] std::unique_ptr<Border> border(const SparseMatrix& columns, const MeterPart& /*meter*/) const override {
    return std::make_unique<SolvedBorder>(*this, columns);
  }

 private:
  [[nodiscard]] SparseMatrix kept_of(const SparseMatrix& A) const {
    std::vector<int> new_index(A.rows(), -1);
    for (size_t k = 0; k < kept_.size(); ++k) new_index[kept_[k]] = static_cast<int>(k);
    SparseMatrix result(kept_.size(), kept_.size());
    result.reserve(A.nonZeros());
    for (size_t k = 0; k < kept_.size(); ++k) {
      result.startVec(k);
      double diagonal = 0;
      for (SparseMatrix::InnerIterator it(A, kept_[k]); it; ++it) {
        if (new_index[it.row()] < 0) continue;
        if (!std::isfinite(it.value())) throw_not_finite(it.row(), it.col(), it.value());
        if (it.row() == kept_[k]) diagonal = it.value();
        result.insertBack(new_index[it.row()], k) = it.value();
      }
      if (!(diagonal > 0)) throw_not_positive_definite();
    }
    result.finalize();
    return result;
  }

  std::vector<int> kept_;  ///< the rows that are not erased
  Solver solver_;
};

template <class Solver>
class EigenSolver final : public LinearSolver {
 public:
  [[nodiscard]] std::unique_ptr<Factorization> factorize(const SparseMatrix& A, const std::vector<char>& is_erased,
                                                         const MeterPart& /*meter*/) const override {
    return std::make_unique<EigenFactorization<Solver>>(A, is_erased);
  }
};

template <class Solver>
class EigenFactory final : public SolverFactory {
 public:
  [[nodiscard]] std::unique_ptr<LinearSolver> make(const SparseMatrix& /*pattern*/) const override {
    return std::make_unique<EigenSolver<Solver>>();
  }
};

}  // namespace

const SolverFactory& reference_solver(ReferenceSolver kind) {
  static const EigenFactory<SimplicialLdlt> simplicial_ldlt;
  static const EigenFactory<SparseLu> sparse_lu;
  static const EigenFactory<SparseQr> sparse_qr;
  static const EigenFactory<BiCgStab> bicgstab;
  switch (kind) {
    case ReferenceSolver::kSparseLu:
      return sparse_lu;
    case ReferenceSolver::kSparseQr:
      return sparse_qr;
    case ReferenceSolver::kBiCgStab:
      return bicgstab;
    case ReferenceSolver::kSimplicialLdlt:
      break;
  }
  return simplicial_ldlt;
}

}  // namespace arap
