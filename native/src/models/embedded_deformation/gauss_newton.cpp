// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/embedded_deformation/gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cholesky/solver_choice.h"
#include "optimize/time_budget.h"

namespace arap {

namespace {

/// Of a hard row, against a soft one of strength 1/2. The larger, the fewer steps to its target, and the less room has
/// the rest meanwhile.
constexpr double kHardWeight = 10;

/// A_j (g_k - g_j) + g_j + t_j - (g_k + t_k) = 0 [SSP07] Eq. (6), as a row.
LinearRow edge_row(int j, int k, const Eigen::RowVector3d& edge) {
  return {{kNodeRows * j, kNodeRows * j + 1, kNodeRows * j + 2, kNodeRows * j + 3, kNodeRows * k + 3},
          {edge[0], edge[1], edge[2], 1, -1}};
}

}  // namespace

GaussNewton::GaussNewton(const DeformationGraph& graph, const EmbeddedOptions& options,
                         const GraphConstraints& constraints, const std::vector<char>& is_held, const Workers& workers,
                         const MeterPart& meter)
    : workers_(workers), node_distance_(options.node_distance) {
  LinearRows rows;
  n_edge_rows_ = 2 * std::ssize(graph.edges);
  edge_goals_.resize(n_edge_rows_, 3);
  for (const auto& [j, k] : graph.edges) {
    const Eigen::RowVector3d edge = graph.node(k) - graph.node(j);
    edge_goals_.row(rows.size()) = edge;
    rows.add(edge_row(j, k, edge), options.regularization_weight);
    edge_goals_.row(rows.size()) = -edge;
    rows.add(edge_row(k, j, -edge), options.regularization_weight);
  }
  const auto n_constraints = std::ssize(constraints.weights);
  const double share = options.constraint_weight * graph.size() / static_cast<double>(n_constraints);
  constants_.resize(n_constraints, 3);
  for (Eigen::Index r = 0; r < n_constraints; ++r) {
    const auto& [row, constant] = constraints.combinations[r];
    const bool is_moved = !row.indices.empty();  // not a loose vertex
    const bool is_hard = constraints.weights[r] == LinearRows::kHard && is_moved;
    is_hard_.push_back(is_hard ? 1 : 0);
    constants_.row(r) = constant;
    rows.add(row, is_hard ? share * kHardWeight : is_moved ? share * constraints.weights[r] : 0);
  }
  learned_ = Positions::Zero(n_constraints, 3);
  weights_ = rows.weight_vector();
  rows_ = RowMatrix(rows, kNodeRows * graph.size());
  meter.add(0.2);
  SparseMatrix K = rows_.normal_matrix(weights_);
  K.makeCompressed();
  unknowns_ = NodeUnknowns::make(options.nodes, options.rotation_weight, K);
  for (const char held : is_held) is_erased_.insert(is_erased_.end(), unknowns_->per_node(), held == 0 ? 1 : 0);
  solver_ = make_linear_solver(unknowns_->matrix(graph.rest_state()), LinearSolverKind::kBlockLdlt, workers,
                               TileFormat::kFloat, meter.part(0.8));
}

GaussNewton::Report GaussNewton::solve(const Positions& targets, const SolveOptions& options, const Progress& progress,
                                       Positions& state) {
  TimeBudget budget(options.time_limit_s);
  const Positions goals = wanted(targets);
  Report report;
  report.energy_before = energy(targets, state);
  double gap = std::numeric_limits<double>::infinity();
  double first_step = 0;
  while (report.iterations < options.max_iterations) {
    if (report.iterations > 0 && !budget.allows_another()) {
      report.stop_reason = StopReason::kTimeLimit;
      break;
    }
    Positions moved_goals = goals;
    moved_goals.bottomRows(learned_.rows()) += learned_;
    Positions next = stepped(moved_goals, state);
    ++report.iterations;
    budget.end_iteration();
    report.step = movement(state, next);
    state = std::move(next);
    const double former_gap = std::exchange(gap, learn(goals, state));
    // Gaps that shrink no more are what the nodes cannot do.
    const bool is_met = gap <= options.accuracy || gap > 0.9 * former_gap;
    if (report.step <= options.accuracy && is_met) {
      report.stop_reason = StopReason::kConverged;
      break;
    }
    first_step = std::max(first_step, report.step);
    if (progress && !progress(std::clamp(std::log(first_step / report.step) /
                                             std::max(std::log(first_step / std::max(options.accuracy, 1e-15)), 1e-9),
                                         0.0, 1.0))) {
      report.stop_reason = StopReason::kCancelled;
      break;
    }
  }
  report.energy_after = energy(targets, state);
  return report;
}

double GaussNewton::energy(const Positions& targets, const Positions& state) const {
  const Positions gaps = rows_.gaps(wanted(targets), state, workers_);
  double sum = unknowns_->energy(state);
  for (Eigen::Index r = 0; r < gaps.rows(); ++r)
    if (r < n_edge_rows_ || is_hard_[r - n_edge_rows_] == 0) sum += weights_[r] * gaps.row(r).squaredNorm();
  return sum;
}

Positions GaussNewton::wanted(const Positions& targets) const {
  Positions result(n_edge_rows_ + targets.rows(), 3);
  result.topRows(n_edge_rows_) = edge_goals_;
  result.bottomRows(targets.rows()) = targets - constants_;
  return result;
}

double GaussNewton::merit(const Positions& wanted, const Positions& state) const {
  return unknowns_->energy(state) +
         weights_.dot(rows_.gaps(wanted, state, workers_).rowwise().squaredNorm());
}

Positions GaussNewton::stepped(const Positions& wanted, const Positions& state) {
  constexpr int kMostHalvings = 30;
  Positions pull = -rows_.gaps(wanted, state, workers_);
  pull.array().colwise() *= weights_.array();
  Positions of_state = Positions::Zero(state.rows(), 3);
  rows_.add_transposed(pull, of_state, workers_);
  // The solver has three right-hand sides; here it needs one.
  const Eigen::VectorXd gradient = unknowns_->gradient(state, of_state);
  Positions step = Positions::Zero(gradient.size(), 3);
  step.col(0) = -gradient;
  for (Eigen::Index k = 0; k < gradient.size(); ++k)
    if (is_erased_[k] != 0) step(k, 0) = 0;
  solver_->factorize(unknowns_->matrix(state), is_erased_)->solve(step);
  ++n_factorizations_;
  const double before = merit(wanted, state);
  double length = 1;
  for (int k = 0; k < kMostHalvings; ++k, length /= 2) {
    Positions next = unknowns_->stepped(state, length * step.col(0));
    if (merit(wanted, next) <= before) return next;
  }
  return state;
}

double GaussNewton::learn(const Positions& goals, const Positions& state) {
  const Positions gaps = rows_.gaps(goals, state, workers_).bottomRows(learned_.rows());
  double largest = 0;
  for (Eigen::Index r = 0; r < learned_.rows(); ++r) {
    if (is_hard_[r] == 0) continue;
    learned_.row(r) += gaps.row(r);
    largest = std::max(largest, gaps.row(r).norm());
  }
  return largest;
}

double GaussNewton::movement(const Positions& from, const Positions& to) const {
  double largest = 0;
  for (Eigen::Index j = 0; j < from.rows() / kNodeRows; ++j) {
    const auto change = to.middleRows<kNodeRows>(kNodeRows * j) - from.middleRows<kNodeRows>(kNodeRows * j);
    largest = std::max(largest, change.row(3).norm() + node_distance_ * change.topRows<3>().norm());
  }
  return largest;
}

}  // namespace arap
