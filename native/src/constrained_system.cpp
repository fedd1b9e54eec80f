// SPDX-License-Identifier: GPL-3.0-or-later
#include "constrained_system.h"

#include <cstddef>
#include <iterator>
#include <utility>

#include "arap/error.h"
#include "union_find.h"

namespace arap {

namespace {

void report(const Progress& progress, double fraction) {
  if (progress && !progress(fraction)) throw Cancelled("the change of constraints was cancelled");
}

/// K plus the diagonal, which is stored whole even where K has none: loose vertices, members of rigid regions.
SparseMatrix with_diagonal(const SparseMatrix& K, const Eigen::VectorXd& diagonal) {
  SparseMatrix D(K.rows(), K.cols());
  D.setIdentity();
  D.diagonal() = diagonal;
  return K + D;
}

}  // namespace

Eigen::RowVector3d Average::of(const Positions& x) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (size_t k = 0; k < indices.size(); ++k) sum += weights[k] * x.row(indices[k]);
  return sum;
}

ConstrainedSystem::ConstrainedSystem(const LinearSolver& solver, const SparseMatrix& K, std::vector<char> is_fixed,
                                     const Eigen::VectorXd& soft_diagonal, std::vector<Average> averages,
                                     const Progress& progress)
    : matrix_(with_diagonal(K, soft_diagonal)), is_fixed_(std::move(is_fixed)), averages_(std::move(averages)) {
  report(progress, 0.1);
  const std::vector<int> grounded = find_unheld(soft_diagonal);
  std::vector<double> grounding;
  grounding.reserve(grounded.size());
  for (const int i : grounded) {
    const double diagonal = matrix_.coeff(i, i);
    grounding.push_back(diagonal > 0 ? diagonal : 1.0);  // a part that is one rigid region has no stiffness at all
  }
  report(progress, 0.2);
  if (grounded.empty()) {
    factor_ = solver.factorize(matrix_, is_fixed_);
  } else {
    SparseMatrix held = matrix_;
    for (size_t k = 0; k < grounded.size(); ++k) held.coeffRef(grounded[k], grounded[k]) += grounding[k];
    factor_ = solver.factorize(held, is_fixed_);
  }
  report(progress, 0.8);
  prepare_dense_part(grounded, grounding);
  report(progress, 1.0);
}

std::vector<int> ConstrainedSystem::find_unheld(const Eigen::VectorXd& soft_diagonal) const {
  const auto n = static_cast<int>(matrix_.rows());
  UnionFind components(n);
  std::vector<char> is_held(n, 0);
  const auto is_free = [&](Eigen::Index i) { return is_fixed_[i] == 0; };
  for (int i = 0; i < n; ++i) {
    if (!is_free(i)) continue;
    if (soft_diagonal[i] > 0) is_held[i] = 1;
    for (SparseMatrix::InnerIterator it(matrix_, i); it; ++it) {
      if (it.row() == i || it.value() == 0) continue;
      if (is_free(it.row()))
        components.join(i, static_cast<int>(it.row()));
      else
        is_held[i] = 1;
    }
  }
  std::vector<char> is_component_held(n, 0);
  for (int i = 0; i < n; ++i)
    if (is_held[i] != 0) is_component_held[components.find(i)] = 1;
  std::vector<int> unheld;
  for (int i = 0; i < n; ++i)
    if (is_free(i) && components.find(i) == i && is_component_held[i] == 0) unheld.push_back(i);
  return unheld;
}

Eigen::VectorXd ConstrainedSystem::column_solution(const Average& column) const {
  Positions b = Positions::Zero(matrix_.rows(), 3);
  for (size_t k = 0; k < column.indices.size(); ++k) b(column.indices[k], 0) += column.weights[k];
  factor_->solve(b);
  return b.col(0);
}

// With A = H - E G E^T (H the factorized matrix, E the grounded unit columns, G = diag(grounding)) and mu = G E^T d,
// the correction d to x under averages W^T (x + d) = t solves
//     H d = r - W lambda + E mu,   W^T d = gap,   mu / G = E^T d.
// With the columns C = [W, -E] and y = (lambda, mu):  d = H^-1 (r - C y),  (C^T H^-1 C - diag(0, 1 / G)) y = C^T H^-1 r
// - (gap, 0).
void ConstrainedSystem::prepare_dense_part(const std::vector<int>& grounded, const std::vector<double>& grounding) {
  if (averages_.empty()) return;
  for (const Average& average : averages_) {
    Average column;
    for (size_t k = 0; k < average.indices.size(); ++k) {
      if (is_fixed_[average.indices[k]] != 0) continue;
      column.indices.push_back(average.indices[k]);
      column.weights.push_back(average.weights[k]);
    }
    columns_.push_back(std::move(column));
  }
  for (const int i : grounded) columns_.push_back({{i}, {-1.0}});
  const std::ptrdiff_t n_columns = std::ssize(columns_);
  column_solutions_.resize(matrix_.rows(), n_columns);
  for (Eigen::Index c = 0; c < n_columns; ++c) column_solutions_.col(c) = column_solution(columns_[c]);
  Eigen::MatrixXd S(n_columns, n_columns);
  for (Eigen::Index r = 0; r < n_columns; ++r) {
    const Average& column = columns_[r];
    S.row(r).setZero();
    for (size_t k = 0; k < column.indices.size(); ++k)
      S.row(r) += column.weights[k] * column_solutions_.row(column.indices[k]);
  }
  for (size_t k = 0; k < grounded.size(); ++k) {
    const size_t i = averages_.size() + k;
    S(i, i) -= 1 / grounding[k];
  }
  // Least squares: averages that contradict each other meet in the middle.
  dense_.setThreshold(1e-12);
  dense_.compute(S);
}

void ConstrainedSystem::correct(Positions& residual, const Positions& gaps, Positions& multipliers) const {
  for (Eigen::Index i = 0; i < residual.rows(); ++i)
    if (is_fixed_[i] != 0) residual.row(i).setZero();
  factor_->solve(residual);
  multipliers.resize(averages_.size(), 3);
  if (averages_.empty()) return;
  Eigen::MatrixX3d right(columns_.size(), 3);
  for (std::ptrdiff_t c = 0; c < std::ssize(columns_); ++c) {
    right.row(c) = columns_[c].of(residual);
    if (c < std::ssize(averages_)) right.row(c) -= gaps.row(c);
  }
  const Eigen::MatrixX3d y = dense_.solve(right);
  residual.noalias() -= column_solutions_ * y;
  multipliers = y.topRows(multipliers.rows());
}

}  // namespace arap
