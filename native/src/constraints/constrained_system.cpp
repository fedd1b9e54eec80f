// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/constrained_system.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "arap/error.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Rows that a thread takes at once.
constexpr int kRows = 2048;

/// Done before and after the columns are solved, which takes a solve for every three of them.
constexpr double kBeforeColumns = 0.8;
constexpr double kAfterColumns = 0.99;

void report(const Progress& progress, double fraction) {
  if (progress && !progress(fraction)) throw Cancelled("the change of constraints was cancelled");
}

SparseMatrix with_diagonal(const SparseMatrix& K, const Eigen::VectorXd& diagonal) {
  SparseMatrix sum = K;
  for (int i = 0; i < static_cast<int>(diagonal.size()); ++i)
    if (diagonal[i] != 0) sum.coeffRef(i, i) += diagonal[i];
  return sum;
}

}  // namespace

Eigen::RowVector3d Average::of(const Positions& x) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (size_t k = 0; k < indices.size(); ++k) sum += weights[k] * x.row(indices[k]);
  return sum;
}

Positions gaps_to(Positions targets, const std::vector<Average>& averages, const Positions& x) {
  for (Eigen::Index k = 0; k < targets.rows(); ++k) targets.row(k) -= averages[k].of(x);
  return targets;
}

ConstrainedSystem::ConstrainedSystem(const LinearSolver& solver, const SparseMatrix& K,
                                     const std::vector<int>& components, std::vector<char> is_fixed,
                                     const Eigen::VectorXd& soft_diagonal, std::vector<Average> averages,
                                     const Progress& progress, Workers workers)
    : matrix_(with_diagonal(K, soft_diagonal)),
      workers_(std::move(workers)),
      is_fixed_(std::move(is_fixed)),
      averages_(std::move(averages)) {
  report(progress, 0.1);
  grounded_ = find_unheld(components, soft_diagonal);
  grounding_.reserve(grounded_.size());
  for (const int i : grounded_) {
    const double diagonal = matrix_.coeff(i, i);
    grounding_.push_back(diagonal > 0 ? diagonal : 1.0);  // a part that is one rigid region has no stiffness at all
  }
  report(progress, 0.2);
  if (grounded_.empty()) {
    factor_ = solver.factorize(matrix_, is_fixed_);
  } else {
    SparseMatrix held = matrix_;
    for (size_t k = 0; k < grounded_.size(); ++k) held.coeffRef(grounded_[k], grounded_[k]) += grounding_[k];
    factor_ = solver.factorize(held, is_fixed_);
  }
  report(progress, kBeforeColumns);
  prepare_dense_part(progress);
  report(progress, 1.0);
}

std::vector<int> ConstrainedSystem::find_unheld(const std::vector<int>& components,
                                                const Eigen::VectorXd& soft_diagonal) const {
  // One fixed unknown holds all free ones of its component, whatever pieces it cuts them into: each of them is beside a
  // fixed one.
  std::vector<char> is_held(is_fixed_.size(), 0);
  for (size_t i = 0; i < is_fixed_.size(); ++i)
    if (is_fixed_[i] != 0 || soft_diagonal[static_cast<Eigen::Index>(i)] > 0) is_held[components[i]] = 1;
  std::vector<int> unheld;
  for (size_t i = 0; i < is_fixed_.size(); ++i)
    if (components[i] == static_cast<int>(i) && is_held[i] == 0) unheld.push_back(static_cast<int>(i));
  return unheld;
}

void ConstrainedSystem::erase_fixed(Positions& x) const {
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (is_fixed_[i] != 0) x.row(i).setZero();
}

void ConstrainedSystem::multiply_held(const Positions& x, Positions& result) const {
  multiply(matrix_, x, result, workers_);
  for (size_t k = 0; k < grounded_.size(); ++k) result.row(grounded_[k]) += grounding_[k] * x.row(grounded_[k]);
  erase_fixed(result);
}

void ConstrainedSystem::solve_columns(const Progress& progress) {
  const std::ptrdiff_t n_columns = std::ssize(columns_);
  column_solutions_.resize(matrix_.rows(), n_columns);
  for (std::ptrdiff_t first = 0; first < n_columns; first += 3) {
    const std::ptrdiff_t n = std::min<std::ptrdiff_t>(3, n_columns - first);
    Positions b = Positions::Zero(matrix_.rows(), 3);
    for (std::ptrdiff_t c = 0; c < n; ++c) {
      const Average& column = columns_[first + c];
      for (size_t k = 0; k < column.indices.size(); ++k) b(column.indices[k], c) += column.weights[k];
    }
    solve_with_cg([this](const Positions& x, Positions& y) { multiply_held(x, y); }, *factor_, b, workers_);
    column_solutions_.middleCols(first, n) = b.leftCols(n);
    const double done = static_cast<double>(first + n) / static_cast<double>(n_columns);
    report(progress, kBeforeColumns + done * (kAfterColumns - kBeforeColumns));
  }
}

// With A = H - E G E^T (H the factorized matrix, E the grounded unit columns, G = diag(grounding)) and mu = G E^T d,
// the correction d to x under averages W^T (x + d) = t solves
//     H d = r - W lambda + E mu,   W^T d = gap,   mu / G = E^T d.
// With the columns C = [W, -E] and y = (lambda, mu):  d = H^-1 (r - C y),  (C^T H^-1 C - diag(0, 1 / G)) y = C^T H^-1 r
// - (gap, 0).
void ConstrainedSystem::prepare_dense_part(const Progress& progress) {
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
  for (const int i : grounded_) columns_.push_back({{i}, {-1.0}});
  solve_columns(progress);
  const std::ptrdiff_t n_columns = std::ssize(columns_);
  Eigen::MatrixXd S(n_columns, n_columns);
  for (Eigen::Index r = 0; r < n_columns; ++r) {
    const Average& column = columns_[r];
    S.row(r).setZero();
    for (size_t k = 0; k < column.indices.size(); ++k)
      S.row(r) += column.weights[k] * column_solutions_.row(column.indices[k]);
  }
  for (size_t k = 0; k < grounded_.size(); ++k) {
    const size_t i = averages_.size() + k;
    S(i, i) -= 1 / grounding_[k];
  }
  // Least squares: averages that contradict each other meet in the middle.
  dense_.setThreshold(1e-12);
  dense_.compute(S);
}

Responses ConstrainedSystem::responses() const {
  Eigen::MatrixXd gaps = Eigen::MatrixXd::Zero(std::ssize(columns_), std::ssize(averages_));
  gaps.diagonal().setOnes();
  const Eigen::MatrixXd y = dense_.solve(gaps);
  return {column_solutions_ * y, y.topRows(std::ssize(averages_))};
}

Positions ConstrainedSystem::meet_averages(Positions& x, const Positions& gaps) const {
  if (averages_.empty()) return {0, 3};
  Eigen::MatrixX3d right(columns_.size(), 3);
  for (std::ptrdiff_t c = 0; c < std::ssize(columns_); ++c) {
    right.row(c) = columns_[c].of(x);
    if (c < std::ssize(averages_)) right.row(c) -= gaps.row(c);
  }
  const Eigen::MatrixX3d y = dense_.solve(right);
  parallel_for<kRows>(workers_, static_cast<int>(x.rows()), [&](int begin, int end) {
    x.middleRows(begin, end - begin).noalias() -= column_solutions_.middleRows(begin, end - begin) * y;
  });
  return y.topRows(averages_.size());
}

void ConstrainedSystem::correct(const Positions& residual, const Positions& gaps, Positions& multipliers,
                                Positions& correction) const {
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  if (multipliers.rows() != n_averages) multipliers = Positions::Zero(n_averages, 3);
  if (n_averages == 0) {
    factor_->solve(residual, correction);
    return;
  }
  if (&correction != &residual) copy_rows(workers_, residual, correction);
  for (std::ptrdiff_t c = 0; c < n_averages; ++c)
    for (size_t k = 0; k < columns_[c].indices.size(); ++k)
      correction.row(columns_[c].indices[k]) -= columns_[c].weights[k] * multipliers.row(c);
  factor_->solve(correction);
  multipliers += meet_averages(correction, gaps);
}

void ConstrainedSystem::correct_to(double accuracy, Positions& residual, const Positions& gaps) const {
  erase_fixed(residual);
  solve_with_cg([this](const Positions& x, Positions& y) { multiply_held(x, y); }, *factor_, residual, workers_,
                accuracy);
  static_cast<void>(meet_averages(residual, gaps));
}

}  // namespace arap
