// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/constrained_system.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>

#include "arap/error.h"
#include "cholesky/solver_choice.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Rows that a thread takes at once.
constexpr int kRows = 2048;

/// Done before the factorization, and before and after the columns are solved: a solve for every three of them.
constexpr double kFactorization = 0.1;
constexpr double kBeforeColumns = 0.8;
constexpr double kAfterColumns = 0.99;
constexpr double kRounding = 1e-9;  // of what adds up between them

/// The penalty of a stiff row in the factor, in units of K's stiffness at its unknowns. More leaves less to the
/// multipliers' iteration, and less of K in the factor's floats.
constexpr double kPenalty = 100;

/// What a correction leaves of the gaps of stiff rows, as a part of what penalties leave. The next one closes that too.
constexpr double kGapsLeft = 1e-2;

/// What is so much smaller than the largest coefficient of a row is rounding.
constexpr double kBalanced = 1e-9;

double largest_coefficient(const LinearRow& row) {
  double largest = 0;
  for (const double coefficient : row.coefficients) largest = std::max(largest, std::abs(coefficient));
  return largest;
}

SparseMatrix with_diagonal(const SparseMatrix& K, const Eigen::VectorXd& diagonal) {
  SparseMatrix sum = K;
  for (int i = 0; i < static_cast<int>(diagonal.size()); ++i)
    if (diagonal[i] != 0) sum.coeffRef(i, i) += diagonal[i];
  return sum;
}

}  // namespace

ConstrainedSystem::ConstrainedSystem(const LinearSolver& solver, LinearSolverKind kind, const SparseMatrix& K,
                                     const std::vector<int>& components, SystemConstraints constraints,
                                     const Progress& progress, Workers workers)
    : matrix_(&K),
      workers_(std::move(workers)),
      is_fixed_(std::move(constraints.is_fixed)),
      averages_(std::move(constraints.averages)) {
  Meter meter(progress, "the change of constraints was cancelled");
  meter.reach(0);
  if ((constraints.soft_diagonal.array() != 0).any()) {
    own_matrix_ = with_diagonal(K, constraints.soft_diagonal);
    matrix_ = &own_matrix_;
  }
  grounded_ = find_unheld(components, constraints);
  n_released_ = sort_by_rows(components, constraints, grounded_);
  grounding_.reserve(grounded_.size());
  for (const int i : grounded_) {
    const double diagonal = matrix_->coeff(i, i);
    grounding_.push_back(diagonal > 0 ? diagonal : 1.0);  // a part that is one rigid region has no stiffness at all
  }
  meter.reach(kFactorization);
  factorize(solver, kind, K, constraints, {&meter, kBeforeColumns - kFactorization - kRounding});
  meter.reach(kBeforeColumns);
  prepare_dense_part(meter);
  meter.reach(1.0);
}

SparseMatrix ConstrainedSystem::grounded() const {
  SparseMatrix held = *matrix_;
  for (size_t k = 0; k < grounded_.size(); ++k) held.coeffRef(grounded_[k], grounded_[k]) += grounding_[k];
  return held;
}

void ConstrainedSystem::factorize(const LinearSolver& solver, LinearSolverKind kind, const SparseMatrix& K,
                                  const SystemConstraints& constraints, const MeterPart& meter) {
  if (!constraints.soft_rows.empty() || !constraints.stiff_rows.empty())
    factorize_with_rows(kind, K, constraints, meter);
  else if (grounded_.empty())
    factor_ = solver.factorize(*matrix_, is_fixed_, meter);
  else
    factor_ = solver.factorize(grounded(), is_fixed_, meter);
}

void ConstrainedSystem::factorize_with_rows(LinearSolverKind kind, const SparseMatrix& K,
                                            const SystemConstraints& constraints, const MeterPart& meter) {
  const int n = static_cast<int>(K.rows());
  const RowMatrix soft(constraints.soft_rows, n);
  own_matrix_ = SparseMatrix(*matrix_ + soft.normal_matrix(constraints.soft_rows.weight_vector()));
  matrix_ = &own_matrix_;
  RowMatrix stiff(constraints.stiff_rows, n);
  const Eigen::VectorXd weights = constraints.stiff_rows.weight_vector();
  const Eigen::VectorXd penalties = (kPenalty * row_stiffness(stiff, K)).cwiseMin(0.5 * weights);
  const SparseMatrix held = grounded() + stiff.normal_matrix(penalties);
  // Halves could not tell K beside rows.
  factor_ = make_linear_solver(held, kind, workers_, TileFormat::kFloat, meter.part(0.5))
                ->factorize(held, is_fixed_, meter.part(0.5));
  if (!stiff.empty()) stiff_ = std::make_unique<StiffRows>(*factor_, std::move(stiff), penalties, weights, workers_);
}

std::vector<int> ConstrainedSystem::find_unheld(const std::vector<int>& components,
                                                const SystemConstraints& constraints) const {
  // One fixed unknown holds all free ones of its component, whatever pieces it cuts them into: each of them is beside a
  // fixed one.
  std::vector<char> is_held(is_fixed_.size(), 0);
  for (size_t i = 0; i < is_fixed_.size(); ++i)
    if (is_fixed_[i] != 0 || constraints.soft_diagonal[static_cast<Eigen::Index>(i)] > 0) is_held[components[i]] = 1;
  // A row holds its component if that cannot move as one without the row's stretching.
  for (const LinearRows* group : {&constraints.soft_rows, &constraints.stiff_rows})
    for (const LinearRow& row : group->rows) {
      const int component = components[row.indices.front()];
      const bool is_of_one =
          std::all_of(row.indices.begin(), row.indices.end(), [&](int i) { return components[i] == component; });
      if (is_of_one && std::abs(row.sum()) > kBalanced * largest_coefficient(row)) is_held[component] = 1;
    }
  std::vector<int> unheld;
  for (size_t i = 0; i < is_fixed_.size(); ++i)
    if (components[i] == static_cast<int>(i) && is_held[i] == 0) unheld.push_back(static_cast<int>(i));
  return unheld;
}

int ConstrainedSystem::sort_by_rows(const std::vector<int>& components, const SystemConstraints& constraints,
                                    std::vector<int>& unheld) const {
  if (unheld.empty()) return 0;
  std::vector<LinearRow> rows = averages_;
  for (const LinearRows* group : {&constraints.soft_rows, &constraints.stiff_rows})
    rows.insert(rows.end(), group->rows.begin(), group->rows.end());
  if (rows.empty()) return 0;
  std::vector<int> column_of_component(components.size(), -1);
  for (size_t k = 0; k < unheld.size(); ++k) column_of_component[components[unheld[k]]] = static_cast<int>(k);
  // How a row stretches if a component moves as one.
  Eigen::MatrixXd stretch = Eigen::MatrixXd::Zero(std::ssize(rows), std::ssize(unheld));
  for (Eigen::Index r = 0; r < stretch.rows(); ++r) {
    const double largest = largest_coefficient(rows[r]);
    for (size_t k = 0; k < rows[r].indices.size(); ++k)
      if (const int column = column_of_component[components[rows[r].indices[k]]]; column >= 0)
        stretch(r, column) += rows[r].coefficients[k] / largest;
  }
  stretch = (stretch.array().abs() > kBalanced).select(stretch, 0.0);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(stretch);
  qr.setThreshold(kBalanced);
  const std::vector<int> given = unheld;
  for (size_t k = 0; k < unheld.size(); ++k) unheld[k] = given[qr.colsPermutation().indices()[static_cast<int>(k)]];
  return static_cast<int>(qr.rank());
}

void ConstrainedSystem::multiply(const Positions& x, Positions& result) const {
  arap::multiply(*matrix_, x, result, workers_);
}

void ConstrainedSystem::solve_exactly(double accuracy, Positions& b, const Positions& gaps,
                                      Positions& multipliers) const {
  if (stiff_ == nullptr) {
    solve_with_cg([this](const Positions& x, Positions& y) { multiply_held(x, y); }, *factor_, b, workers_, accuracy);
    return;
  }
  constexpr int kMostSteps = 20;
  constexpr double kSlow = 0.5;
  Positions x = Positions::Zero(b.rows(), 3);
  Positions residual = b;
  Positions gaps_left = gaps;
  Positions step;
  Positions product;
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kMostSteps; ++k) {
    stiff_->solve(kGapsLeft, residual, gaps_left, multipliers, step);
    const double length = step.norm();
    if (!(length < last)) break;
    x += step;
    if (length <= accuracy * x.norm() || length > kSlow * last) break;
    last = length;
    multiply_held(x, product);
    residual = b - product;
    stiff_->rows().multiply(x, product, workers_);
    gaps_left = gaps - product;
  }
  b.swap(x);
}

void ConstrainedSystem::erase_fixed(Positions& x) const {
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (is_fixed_[i] != 0) x.row(i).setZero();
}

void ConstrainedSystem::multiply_held(const Positions& x, Positions& result) const {
  multiply(x, result);
  for (size_t k = 0; k < grounded_.size(); ++k) result.row(grounded_[k]) += grounding_[k] * x.row(grounded_[k]);
  erase_fixed(result);
}

void ConstrainedSystem::solve_columns(Meter& meter) {
  const std::ptrdiff_t n_columns = std::ssize(columns_);
  column_solutions_.resize(matrix_->rows(), n_columns);
  column_forces_.resize(n_stiff(), n_columns);
  for (std::ptrdiff_t first = 0; first < n_columns; first += 3) {
    const std::ptrdiff_t n = std::min<std::ptrdiff_t>(3, n_columns - first);
    Positions b = Positions::Zero(matrix_->rows(), 3);
    for (std::ptrdiff_t c = 0; c < n; ++c) {
      const LinearRow& column = columns_[first + c];
      for (size_t k = 0; k < column.indices.size(); ++k) b(column.indices[k], c) += column.coefficients[k];
    }
    Positions forces = Positions::Zero(n_stiff(), 3);
    solve_exactly(kDoubleAccuracy, b, Positions::Zero(n_stiff(), 3), forces);
    column_solutions_.middleCols(first, n) = b.leftCols(n);
    column_forces_.middleCols(first, n) = forces.leftCols(n);
    const double done = static_cast<double>(first + n) / static_cast<double>(n_columns);
    meter.reach(kBeforeColumns + done * (kAfterColumns - kBeforeColumns));
  }
}

// With A = H - E G E^T (H the factorized matrix, E the released unit columns, G = diag(grounding)) and mu = G E^T d,
// the correction d to x under averages W^T (x + d) = t solves
//     H d = r - W lambda + E mu,   W^T d = gap,   mu / G = E^T d.
// With the columns C = [W, -E] and y = (lambda, mu):  d = H^-1 (r - C y),  (C^T H^-1 C - diag(0, 1 / G)) y = C^T H^-1 r
// - (gap, 0).
void ConstrainedSystem::prepare_dense_part(Meter& meter) {
  if (averages_.empty() && n_released_ == 0) return;
  for (const LinearRow& average : averages_) {
    LinearRow column;
    for (size_t k = 0; k < average.indices.size(); ++k) {
      if (is_fixed_[average.indices[k]] != 0) continue;
      column.indices.push_back(average.indices[k]);
      column.coefficients.push_back(average.coefficients[k]);
    }
    columns_.push_back(std::move(column));
  }
  for (int k = 0; k < n_released_; ++k) columns_.push_back({{grounded_[k]}, {-1.0}});
  solve_columns(meter);
  const std::ptrdiff_t n_columns = std::ssize(columns_);
  Eigen::MatrixXd S(n_columns, n_columns);
  for (Eigen::Index r = 0; r < n_columns; ++r) {
    const LinearRow& column = columns_[r];
    S.row(r).setZero();
    for (size_t k = 0; k < column.indices.size(); ++k)
      S.row(r) += column.coefficients[k] * column_solutions_.row(column.indices[k]);
  }
  for (int k = 0; k < n_released_; ++k) {
    const Eigen::Index i = std::ssize(averages_) + k;
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

void ConstrainedSystem::meet_averages(Positions& x, const Positions& gaps, Positions& multipliers) const {
  if (columns_.empty()) return;
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  Eigen::MatrixX3d right(columns_.size(), 3);
  for (std::ptrdiff_t c = 0; c < std::ssize(columns_); ++c) {
    right.row(c) = columns_[c].of(x);
    if (c < n_averages) right.row(c) -= gaps.row(c);
  }
  const Eigen::MatrixX3d y = dense_.solve(right);
  parallel_for<kRows>(workers_, static_cast<int>(x.rows()), [&](int begin, int end) {
    x.middleRows(begin, end - begin).noalias() -= column_solutions_.middleRows(begin, end - begin) * y;
  });
  multipliers.topRows(n_averages) += y.topRows(n_averages);
  multipliers.bottomRows(n_stiff()) -= column_forces_ * y;
}

void ConstrainedSystem::correct(const Positions& residual, const Positions& gaps, Positions& multipliers,
                                Positions& correction) const {
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  if (multipliers.rows() != n_held()) multipliers = Positions::Zero(n_held(), 3);
  if (columns_.empty() && stiff_ == nullptr) {
    factor_->solve(residual, correction);
    return;
  }
  if (&correction != &residual) copy_rows(workers_, residual, correction);
  for (std::ptrdiff_t c = 0; c < n_averages; ++c)
    for (size_t k = 0; k < columns_[c].indices.size(); ++k)
      correction.row(columns_[c].indices[k]) -= columns_[c].coefficients[k] * multipliers.row(c);
  if (stiff_ == nullptr) {
    factor_->solve(correction);
  } else {
    Positions of_stiff = multipliers.bottomRows(n_stiff());
    stiff_->solve(kGapsLeft, correction, gaps.bottomRows(n_stiff()), of_stiff, correction);
    multipliers.bottomRows(n_stiff()) = of_stiff;
  }
  meet_averages(correction, gaps, multipliers);
}

void ConstrainedSystem::correct_to(double accuracy, Positions& residual, const Positions& gaps) const {
  erase_fixed(residual);
  Positions multipliers = Positions::Zero(n_held(), 3);
  Positions of_stiff = Positions::Zero(n_stiff(), 3);
  solve_exactly(accuracy, residual, gaps.bottomRows(n_stiff()), of_stiff);
  meet_averages(residual, gaps, multipliers);
}

}  // namespace arap
