// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/references/bicgstab.h"

#include <Eigen/IterativeLinearSolvers>
#include <mutex>

#include "arap/error.h"
#include "base/format_message.h"
#include "cholesky/references/kept_rows.h"

namespace arap {

namespace {

class BiCgStabFactorization final : public Factorization {
 public:
  BiCgStabFactorization(const SparseMatrix& A, const std::vector<char>& is_erased) : rows_(is_erased) {
    if (rows_.empty()) return;
    matrix_ = rows_.of(A);
    iteration_.setTolerance(BiCgStab::kTolerance);
    iteration_.setMaxIterations(kMostIterations);
    iteration_.preconditioner().setDroptol(kDropped);
    iteration_.preconditioner().setFillfactor(kFill);
    iteration_.compute(matrix_);
    if (iteration_.info() != Eigen::Success) refuse_indefinite();
  }

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override {
    rows_.solve(b, x, [this](Eigen::MatrixX3d right) {
      for (Eigen::Index c = 0; c < 3; ++c) right.col(c) = solve_column(right.col(c));
      return right;
    });
  }

 private:
  static constexpr int kMostIterations = 2000;
  static constexpr double kDropped = 1e-3;
  static constexpr int kFill = 10;

  [[nodiscard]] Eigen::VectorXd solve_column(const Eigen::VectorXd& b) const {
    // Of length 1: the squares of a residual near the end of a solve would leave the range of double.
    const double length = b.stableNorm();
    if (length == 0) return b;
    const std::scoped_lock one_at_a_time(busy_);  // Eigen notes the outcome in the object
    const Eigen::VectorXd x = iteration_.solve(b / length);
    if (iteration_.info() != Eigen::Success)
      throw SolverError(text("BiCGSTAB did not converge: residual ", iteration_.error(), " after ",
                             iteration_.iterations(), " iterations, wanted ", BiCgStab::kTolerance,
                             "; take another linear_solver"));
    return length * x;
  }

  KeptRows rows_;
  SparseMatrix matrix_;  ///< the iteration refers to it
  Eigen::BiCGSTAB<SparseMatrix, Eigen::IncompleteLUT<double>> iteration_;
  mutable std::mutex busy_;
};

}  // namespace

std::unique_ptr<Factorization> BiCgStab::factorize(const SparseMatrix& A, const std::vector<char>& is_erased) const {
  return std::make_unique<BiCgStabFactorization>(A, is_erased);
}

}  // namespace arap
