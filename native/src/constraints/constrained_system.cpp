// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/constrained_system.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>

#include "arap/error.h"
#include "base/available_memory.h"
#include "base/eigen_compat.h"
#include "cholesky/preconditioned_cg.h"
#include "cholesky/solver_choice.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Done before the factorization, and before and after the border is made.
constexpr double kFactorization = 0.1;
constexpr double kBeforeBorder = 0.8;
constexpr double kAfterBorder = 0.99;
constexpr double kRounding = 1e-9;  // of what adds up between them

/// Of the border: its columns, and their products. The dense system takes the rest.
constexpr double kSparse = 0.5;
constexpr double kProducts = 0.2;

/// As large as the border has columns, squared, that are there at once while the dense system is made.
constexpr double kDenseMatrices = 6;

/// The penalty of a stiff row in the factor, in units of K's stiffness at its unknowns. More leaves less to the
/// multipliers' iteration, and less of K in the factor's floats.
constexpr double kPenalty = 100;

/// What a correction leaves of the gaps of stiff rows, as a part of what penalties leave. The next one closes that too.
constexpr double kGapsLeft = 1e-2;

/// Weight of averages beside stiff rows, in units of K's stiffness: as hard rows have.
constexpr double kLikeStiff = 1e7;

/// What is so much smaller than the largest coefficient of a row is rounding.
constexpr double kBalanced = 1e-9;

double largest_coefficient(const LinearRow& row) {
  double largest = 0;
  for (const double coefficient : row.coefficients) largest = std::max(largest, std::abs(coefficient));
  return largest;
}

/// C^T x.
Eigen::MatrixX3d transposed_product(const SparseMatrix& columns, const Positions& x) {
  Eigen::MatrixX3d result = Eigen::MatrixX3d::Zero(columns.cols(), 3);
  for (int c = 0; c < static_cast<int>(columns.cols()); ++c)
    for (SparseMatrix::InnerIterator it(columns, c); it; ++it) result.row(c) += it.value() * x.row(it.row());
  return result;
}

/// x += C y.
void add_product(const SparseMatrix& columns, const Eigen::MatrixX3d& y, Positions& x) {
  for (int c = 0; c < static_cast<int>(columns.cols()); ++c)
    for (SparseMatrix::InnerIterator it(columns, c); it; ++it) x.row(it.row()) += it.value() * y.row(c);
}

SparseMatrix with_diagonal(const SparseMatrix& K, const Eigen::VectorXd& diagonal) {
  SparseMatrix sum = K;
  for (int i = 0; i < static_cast<int>(diagonal.size()); ++i)
    if (diagonal[i] != 0) sum.coeffRef(i, i) += diagonal[i];
  return sum;
}

}  // namespace

ConstrainedSystem::ConstrainedSystem(const LinearSolver& solver, const SolverFactory* factory, const SparseMatrix& K,
                                     const std::vector<int>& components, SystemConstraints constraints,
                                     const Progress& progress, Workers workers)
    : matrix_(&K),
      workers_(std::move(workers)),
      is_fixed_(std::move(constraints.is_fixed)),
      averages_(std::move(constraints.averages)) {
  Meter meter(progress, "the change of constraints was cancelled");
  meter.reach(0);
  for (size_t i = 0; i < is_fixed_.size(); ++i)
    if (is_fixed_[i] != 0) fixed_.push_back(static_cast<int>(i));
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
  find_moves(components);
  factorize(solver, factory, K, constraints, {&meter, kBeforeBorder - kFactorization - kRounding});
  meter.reach(kBeforeBorder);
  prepare_border({&meter, kAfterBorder - kBeforeBorder - kRounding});
  meter.reach(1.0);
}

SparseMatrix ConstrainedSystem::grounded() const {
  SparseMatrix held = *matrix_;
  for (size_t k = 0; k < grounded_.size(); ++k) held.coeffRef(grounded_[k], grounded_[k]) += grounding_[k];
  return held;
}

void ConstrainedSystem::factorize(const LinearSolver& solver, const SolverFactory* factory, const SparseMatrix& K,
                                  const SystemConstraints& constraints, const MeterPart& meter) {
  if (!constraints.soft_rows.empty() || !constraints.stiff_rows.empty())
    factorize_with_rows(factory, K, constraints, meter);
  else if (grounded_.empty())
    factor_ = solver.factorize(*matrix_, is_fixed_, meter);
  else
    factor_ = solver.factorize(grounded(), is_fixed_, meter);
}

void ConstrainedSystem::factorize_with_rows(const SolverFactory* factory, const SparseMatrix& K,
                                            const SystemConstraints& constraints, const MeterPart& meter) {
  const int n = static_cast<int>(K.rows());
  const RowMatrix soft(constraints.soft_rows, n);
  const SparseMatrix of_soft = soft.normal_matrix(constraints.soft_rows.weight_vector());
  own_matrix_ = SparseMatrix(*matrix_ + of_soft);
  matrix_ = &own_matrix_;
  RowMatrix stiff(constraints.stiff_rows, n);
  const Eigen::VectorXd weights = constraints.stiff_rows.weight_vector();
  const Eigen::VectorXd penalties = (kPenalty * row_stiffness(stiff, K)).cwiseMin(0.5 * weights);
  const SparseMatrix of_stiff = stiff.normal_matrix(penalties);
  move_forces_ = (of_soft + of_stiff) * moves_;
  const SparseMatrix held = grounded() + of_stiff;
  // Halves could not tell K beside rows.
  factor_ = make_linear_solver(held, workers_, TileFormat::kFloat, meter.part(0.5), factory)
                ->factorize(held, is_fixed_, meter.part(0.5));
  n_exact_ = constraints.n_exact;
  if (n_exact_ > 0) {
    LinearRows exact;
    const Eigen::VectorXd of_averages = row_stiffness(RowMatrix({averages_, {}}, n), K);
    for (size_t k = 0; k < averages_.size(); ++k)
      exact.add(averages_[k], kLikeStiff * of_averages[static_cast<Eigen::Index>(k)]);
    for (int r = stiff.size() - n_exact_; r < stiff.size(); ++r)
      exact.add(constraints.stiff_rows.rows[r], constraints.stiff_rows.weights[r]);
    to_exact_ = SmallestChange(exact, is_fixed_);
  }
  if (!stiff.empty()) stiff_ = std::make_unique<StiffRows>(std::move(stiff), penalties, weights, workers_);
}

void ConstrainedSystem::close_exact(const Positions& gaps, Positions& x) const {
  if (n_exact_ == 0) return;
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  Positions of_stiff;
  stiff_->rows().multiply(x, of_stiff, workers_);
  Positions left(n_averages + n_exact_, 3);
  left << gaps.topRows(n_averages) - transposed_product(free_averages_, x),
      gaps.bottomRows(n_exact_) - of_stiff.bottomRows(n_exact_);
  to_exact_.close(left, x, workers_);
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
  const auto [order, rank] = pivot_columns(stretch, kBalanced);
  const std::vector<int> given = unheld;
  for (size_t k = 0; k < unheld.size(); ++k) unheld[k] = given[order[static_cast<int>(k)]];
  return rank;
}

void ConstrainedSystem::find_moves(const std::vector<int>& components) {
  std::vector<int> move_of(components.size(), -1);
  for (int k = 0; k < n_released_; ++k) move_of[components[grounded_[k]]] = k;
  std::vector<Eigen::Triplet<double>> entries;
  if (n_released_ > 0)
    for (size_t i = 0; i < components.size(); ++i)
      if (const int k = move_of[components[i]]; k >= 0) entries.emplace_back(static_cast<int>(i), k, 1 / grounding_[k]);
  moves_ = SparseMatrix(matrix_->rows(), n_released_);
  moves_.setFromTriplets(entries.begin(), entries.end());
  move_forces_ = SparseMatrix(matrix_->rows(), n_released_);
}

void ConstrainedSystem::multiply(const Positions& x, Positions& result) const {
  arap::multiply(*matrix_, x, result, workers_);
}

void ConstrainedSystem::erase_fixed(Positions& x) const {
  for (const int i : fixed_) x.row(i).setZero();
}

void ConstrainedSystem::multiply_held(const Positions& x, Positions& result) const {
  multiply(x, result);
  for (size_t k = n_released_; k < grounded_.size(); ++k)
    result.row(grounded_[k]) += grounding_[k] * x.row(grounded_[k]);
  erase_fixed(result);
}

// With A = H - E G E^T (H the factorized matrix, E the grounded unknowns of the released components, G their
// grounding), the components' moves Z, E^T Z = G^-1, and V = A Z (K has no forces against Z, rows may have), it is
// H Z = E + V. The correction d to x under averages W^T d = gaps solves, with the multipliers y and s = G E^T d,
//     d = H^-1 (r - W y - V s) + Z s,   W^T d = gaps,   Z^T (r - W y - V s) = V^T H^-1 (r - W y - V s),
// the last from E^T H^-1 = (Z - H^-1 V)^T. With C = [W, V] that is
//     (C^T H^-1 C - [0, W^T Z; Z^T W, Z^T V]) (y, s) = C^T H^-1 r - (gaps, Z^T r).
// All entries have the unit 1/K, so the stiffness of the whole decides no rank. Where H is only near the true one, d is
// the minimizer with a matrix near A that has the same null space.
void ConstrainedSystem::prepare_border(const MeterPart& meter) {
  if (averages_.empty() && n_released_ == 0) return;
  const Eigen::Index n = matrix_->rows();
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  std::vector<Eigen::Triplet<double>> of_averages;
  for (std::ptrdiff_t c = 0; c < n_averages; ++c)
    for (size_t k = 0; k < averages_[c].indices.size(); ++k)
      if (const int i = averages_[c].indices[k]; is_fixed_[i] == 0)
        of_averages.emplace_back(i, static_cast<int>(c), averages_[c].coefficients[k]);
  free_averages_ = SparseMatrix(n, n_averages);
  free_averages_.setFromTriplets(of_averages.begin(), of_averages.end());
  for (int k = 0; k < n_released_; ++k)
    for (SparseMatrix::InnerIterator it(move_forces_, k); it; ++it)
      if (is_fixed_[it.row()] == 0)
        of_averages.emplace_back(static_cast<int>(it.row()), static_cast<int>(n_averages) + k, it.value());
  SparseMatrix columns(n, n_averages + n_released_);
  columns.setFromTriplets(of_averages.begin(), of_averages.end());
  const auto size = static_cast<double>(columns.cols());
  require_memory(kDenseMatrices * sizeof(double) * size * size, "what joins the patches of this mesh");
  border_ = factor_->border(columns, meter.part(kSparse));
  Eigen::MatrixXd S = border_->products();
  meter.add(kProducts);
  const SparseMatrix rows = free_averages_.transpose();
  const Eigen::MatrixXd of_moves = rows * moves_;
  S.topRightCorner(n_averages, n_released_) -= of_moves;
  S.bottomLeftCorner(n_released_, n_averages) -= of_moves.transpose();
  S.bottomRightCorner(n_released_, n_released_) -= SparseMatrix(moves_.transpose()) * move_forces_;
  // Least squares: averages that contradict each other meet in the middle.
  dense_.compute(S);
  meter.add(1 - kSparse - kProducts);
  overlaps_.compute(rows * free_averages_);
}

Responses ConstrainedSystem::responses(const std::vector<int>& moved) const {
  const std::ptrdiff_t n_moved = std::ssize(moved);
  Responses result{Eigen::MatrixXd(matrix_->rows(), n_moved), Eigen::MatrixXd(n_moved, n_moved)};
  for (std::ptrdiff_t first = 0; first < n_moved; first += 3) {
    const std::ptrdiff_t n = std::min<std::ptrdiff_t>(3, n_moved - first);
    Positions gaps = Positions::Zero(n_held(), 3);
    for (std::ptrdiff_t c = 0; c < n; ++c) gaps(moved[first + c], c) = 1;
    Positions x = Positions::Zero(matrix_->rows(), 3);
    Positions of_stiff = Positions::Zero(n_stiff(), 3);
    solve_exactly(kDoubleAccuracy, gaps, of_stiff, x);
    result.steps.middleCols(first, n) = x.leftCols(n);
    Positions pull;
    multiply_held(x, pull);
    if (stiff_ != nullptr) stiff_->rows().add_transposed(of_stiff, pull, workers_);
    result.stiffness.middleCols(first, n) = forces_of_averages(pull)(moved, all).leftCols(n);
  }
  return result;
}

Eigen::MatrixX3d ConstrainedSystem::solve_held(const Eigen::MatrixX3d& values, Positions& x) const {
  if (border_ == nullptr) {
    factor_->solve(x);
    return values;
  }
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  Eigen::MatrixX3d right(n_averages + n_released_, 3);
  right << values, transposed_product(moves_, x);
  Eigen::MatrixX3d y = Eigen::MatrixX3d::Zero(right.rows(), 3);
  border_->solve([&](const Eigen::MatrixX3d& products) { return y = dense_.solve(products - right); }, x);
  add_product(moves_, y.bottomRows(n_released_), x);
  close(values, x);
  return y.topRows(n_averages);
}

Eigen::MatrixX3d ConstrainedSystem::solve_held_at_zero(Positions& x) const {
  return solve_held(Eigen::MatrixX3d::Zero(std::ssize(averages_), 3), x);
}

void ConstrainedSystem::close(const Eigen::MatrixX3d& values, Positions& x) const {
  add_product(free_averages_, overlaps_.solve(values - transposed_product(free_averages_, x)), x);
}

Eigen::MatrixX3d ConstrainedSystem::forces_of_averages(const Positions& forces) const {
  return overlaps_.solve(transposed_product(free_averages_, forces));
}

Eigen::MatrixX3d ConstrainedSystem::start_held(const Positions& gaps, Positions& x, Positions& b,
                                               Positions& stiff_gaps) const {
  const Eigen::MatrixX3d forces = solve_held(gaps.topRows(std::ssize(averages_)), x);
  Positions product;
  multiply_held(x, product);
  b -= product;
  add_product(free_averages_, -forces, b);
  if (stiff_ == nullptr) return forces;
  Positions of_rows;  // not in the place of the other: memory that is not there for another size would be freed twice
  stiff_->rows().multiply(x, of_rows, workers_);
  stiff_gaps -= of_rows;
  return forces;
}

void ConstrainedSystem::correct(const Positions& residual, const Positions& gaps, Positions& multipliers,
                                Positions& correction) const {
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  if (multipliers.rows() != n_held()) multipliers = Positions::Zero(n_held(), 3);
  if (border_ == nullptr && stiff_ == nullptr) {
    factor_->solve(residual, correction);
    return;
  }
  if (&correction != &residual) copy_rows(workers_, residual, correction);
  add_product(free_averages_, -multipliers.topRows(n_averages), correction);
  if (stiff_ == nullptr)
    multipliers.topRows(n_averages) += solve_held(gaps.topRows(n_averages), correction);
  else
    correct_with_stiff(gaps, multipliers, correction);
}

void ConstrainedSystem::correct_with_stiff(const Positions& gaps, Positions& multipliers, Positions& correction) const {
  const std::ptrdiff_t n_averages = std::ssize(averages_);
  Positions stiff_gaps = gaps.bottomRows(n_stiff());
  Positions start;
  // At the minimizer, and without averages, there is nothing to start with.
  if (!gaps.topRows(n_averages).isZero(0)) {
    start = Positions::Zero(correction.rows(), 3);
    multipliers.topRows(n_averages) += start_held(gaps, start, correction, stiff_gaps);
  }
  Positions of_stiff = multipliers.bottomRows(n_stiff());
  Positions step;
  stiff_->solve(
      kGapsLeft, [this](Positions& x) { solve_held_at_zero(x); }, correction, stiff_gaps, of_stiff, step);
  multipliers.bottomRows(n_stiff()) = of_stiff;
  if (n_averages > 0) {
    Positions product;
    multiply_held(step, product);
    correction -= product;
    stiff_->rows().add_transposed(-of_stiff, correction, workers_);
    multipliers.topRows(n_averages) += forces_of_averages(correction);
  }
  correction.swap(step);
  if (start.rows() > 0) correction += start;
  close_exact(gaps, correction);
}

void ConstrainedSystem::correct_to(double accuracy, Positions& residual, const Positions& gaps) const {
  erase_fixed(residual);
  Positions of_stiff = Positions::Zero(n_stiff(), 3);
  solve_exactly(accuracy, gaps, of_stiff, residual);
}

void ConstrainedSystem::solve_exactly(double accuracy, const Positions& gaps, Positions& of_stiff, Positions& b) const {
  Positions stiff_gaps = gaps.bottomRows(n_stiff());
  Positions start;
  if (border_ != nullptr) {
    start = stiff_ == nullptr ? b : Positions(Positions::Zero(b.rows(), 3));
    start_held(gaps, start, b, stiff_gaps);
  }
  if (stiff_ != nullptr)
    solve_stiff_exactly(accuracy, stiff_gaps, of_stiff, b);
  else
    solve_with_cg([this](const Positions& x, Positions& y) { multiply_held(x, y); },
                  [this](Positions& residual, Positions& x) {
                    copy_rows(workers_, residual, x);
                    // What holds the averages is no force on what keeps them. Its rounding would end the iteration.
                    add_product(free_averages_, -solve_held_at_zero(x), residual);
                  },
                  b, workers_, accuracy);
  if (border_ != nullptr) b += start;
  close_exact(gaps, b);
}

void ConstrainedSystem::solve_stiff_exactly(double accuracy, const Positions& stiff_gaps, Positions& of_stiff,
                                            Positions& b) const {
  constexpr int kMostSteps = 20;
  constexpr double kSlow = 0.5;
  Positions x = Positions::Zero(b.rows(), 3);
  Positions residual = b;
  Positions gaps_left = stiff_gaps;
  Positions step;
  Positions product;
  Positions of_rows;
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kMostSteps; ++k) {
    stiff_->solve(
        kGapsLeft, [this](Positions& y) { solve_held_at_zero(y); }, residual, gaps_left, of_stiff, step);
    const double length = step.norm();
    if (!(length < last)) break;
    x += step;
    if (length <= accuracy * x.norm() || length > kSlow * last) break;
    last = length;
    multiply_held(x, product);
    residual = b - product;
    stiff_->rows().multiply(x, of_rows, workers_);
    gaps_left = stiff_gaps - of_rows;
  }
  b.swap(x);
}

}  // namespace arap
