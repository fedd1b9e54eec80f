// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/embedded_deformation/newton_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/available_memory.h"
#include "cholesky/solver_choice.h"
#include "geometry/rotation.h"
#include "optimize/time_budget.h"

namespace arap {

namespace {

/// Of a hard row, against a soft one of strength 1/2. The larger, the fewer steps to its target, and the less room has
/// the rest meanwhile.
constexpr double kHardWeight = 100;

/// Of a gap, as a part of its goal.
constexpr double kRounding = 2e-15;

/// A step that is a larger part of the one before wants the matrix of where it is.
constexpr double kSlow = 0.5;
/// Multipliers are learned where steps are this part of the gap, so often at most, and no more where the gap does not
/// shrink to this part: the nodes cannot do it then.
constexpr double kSettled = 0.1;
constexpr double kLearning = 0.9;
constexpr int kMostLearnings = 20;

/// A rigid motion goes before all steps if it leaves less than this part of the cost: a drag seldom needs one.
constexpr double kFarLess = 0.1;

/// From the first step to the accuracy, in digits.
double progress_of(double first_step, double step, double accuracy) {
  const double whole = std::log(first_step / std::max(accuracy, 1e-15));
  return whole > 0 && step > 0 ? std::clamp(std::log(first_step / step) / whole, 0.0, 1.0) : 1;
}

/// How far the minimum is: further steps sum to this if they shrink as the last ones did; the last one at least. With
/// some to spare, as the first of them shrink faster than the last.
double distance_left(double step, double former_step) {
  constexpr double kSafety = 8;
  if (step >= former_step) return std::numeric_limits<double>::infinity();
  return kSafety * step * std::max(1.0, step / (former_step - step));
}

/// A_j (g_k - g_j) + g_j + t_j - (g_k + t_k) = 0 [SSP07] Eq. (6), as a row.
LinearRow edge_row(int j, int k, const Eigen::RowVector3d& edge) {
  return {{kNodeRows * j, kNodeRows * j + 1, kNodeRows * j + 2, kNodeRows * j + 3, kNodeRows * k + 3},
          {edge[0], edge[1], edge[2], 1, -1}};
}

/// Of a step's matrix, its triplets and factor. Measured at 17,000 affine nodes with smooth weights.
double bytes_to_step(const DeformationGraph& graph) {
  constexpr double kPerEdge = 2000;
  return kPerEdge * static_cast<double>(graph.edges.size());
}

}  // namespace

NewtonSteps::NewtonSteps(const DeformationGraph& graph, const EmbeddedOptions& options,
                         const GraphConstraints& constraints, const std::vector<char>& is_held, const Workers& workers,
                         const MeterPart& meter)
    : workers_(workers), node_distance_(options.node_distance), nodes_(graph.size(), 3) {
  for (int j = 0; j < graph.size(); ++j) nodes_.row(j) = graph.node(j);
  meter.tell();
  require_memory(bytes_to_step(graph), "this graph");
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
  const auto is_moved = [](const DeformationGraph::Combination& of) { return !of.row.indices.empty(); };
  const auto n_moved = std::max<std::ptrdiff_t>(1, std::ranges::count_if(constraints.combinations, is_moved));
  const double share = options.constraint_weight * graph.size() / static_cast<double>(n_moved);
  constants_.resize(n_constraints, 3);
  for (Eigen::Index r = 0; r < n_constraints; ++r) {
    const DeformationGraph::Combination& combination = constraints.combinations[r];
    const bool is_hard = constraints.weights[r] == LinearRows::kHard;
    constants_.row(r) = combination.constant;
    if (is_moved(combination)) {
      is_hard_.push_back(is_hard ? 1 : 0);
      rows.add(combination.row, share * (is_hard ? kHardWeight : constraints.weights[r]));
    } else {
      is_hard_.push_back(0);
      rows.add({}, 0);
    }
  }
  learned_.moves = Positions::Zero(n_constraints, 3);
  weights_ = rows.weight_vector();
  rows_ = RowMatrix(rows, kNodeRows * graph.size());
  meter.add(0.2);
  SparseMatrix K = rows_.normal_matrix(weights_);
  K.makeCompressed();
  unknowns_ = NodeUnknowns::make(options.nodes, options.rotation_weight, K);
  for (const char held : is_held) is_erased_.insert(is_erased_.end(), unknowns_->per_node(), held == 0 ? 1 : 0);
  const Positions rest = graph.rest_state();
  solver_ =
      make_linear_solver(unknowns_->matrix(rest, Positions::Zero(rest.rows(), 3), NodeUnknowns::Curvature::kWhole),
                         workers, TileFormat::kFloat, meter.part(0.8));
}

NewtonSteps::Report NewtonSteps::solve(const Positions& targets, const SolveOptions& options, const Progress& progress,
                                       Positions& state) {
  TimeBudget budget(options.time_limit_s);
  const Positions goals = wanted(targets);
  // What was learned of another pose, or of other targets, would draw this one elsewhere.
  if (options.initial_guess != InitialGuess::kPrevious) forget();
  if (targets.rows() != last_targets_.rows() || targets != last_targets_) forget_multipliers();
  last_targets_ = targets;
  Place at = place(goals, std::move(state));
  // Half a turn is a maximum or saddle, where steps would end.
  Place rigid = place(goals, turned(goals, at));
  if (cost(rigid.state, rigid.gaps) < kFarLess * cost(at.state, at.gaps)) at = std::move(rigid);
  Report report;
  report.energy_before = energy(at);
  double told = 0;
  double first_step = 0;
  double former_step = std::numeric_limits<double>::infinity();
  while (report.iterations < options.max_iterations) {
    if (report.iterations > 0 && !budget.allows_another()) {
      report.stop_reason = StopReason::kTimeLimit;
      break;
    }
    const Step taken = step(goals, at);
    report.step = taken.moved;
    ++report.iterations;
    budget.end_iteration();
    if (taken.whole > kSlow * former_step) is_stale_ = true;
    const bool is_lost = taken.is_lost && options.accuracy > 0;
    const bool is_still = is_lost || distance_left(taken.whole, former_step) <= options.accuracy;
    former_step = taken.whole;
    first_step = std::max(first_step, taken.whole);
    const double gap = largest_gap(at);
    // What holds a gap moves what is around it farther than the gap is.
    constexpr double kOfGaps = 8;
    const bool is_met = kOfGaps * gap <= options.accuracy;
    if (is_still && (is_met || learned_.is_all)) {
      report.stop_reason = StopReason::kConverged;
      break;
    }
    // Not earlier: multipliers of a pose that is far from its minimum would have to be unlearned.
    if (!is_met && !learned_.is_all && (is_still || taken.whole <= kSettled * gap)) {
      learn(at, gap);
      former_step = std::numeric_limits<double>::infinity();
    }
    // Steps grow again when multipliers are learned.
    told = std::max(told, progress_of(first_step, taken.whole, options.accuracy));
    if (progress && !progress(told)) {
      report.stop_reason = StopReason::kCancelled;
      break;
    }
  }
  if (report.stop_reason != StopReason::kCancelled && progress && !progress(1))
    report.stop_reason = StopReason::kCancelled;
  report.energy_after = energy(at);
  state = std::move(at.state);
  return report;
}

Positions NewtonSteps::turned(const Positions& targets, const Positions& state) const {
  const Positions goals = wanted(targets);
  return turned(goals, place(goals, state));
}

Positions NewtonSteps::turned(const Positions& goals, const Place& at) const {
  const Positions& state = at.state;
  // What nodes move, where it is and at its targets, about the middles.
  const Eigen::Index n = constants_.rows();
  const double sum = weights_.tail(n).sum();
  if (!(sum > 0)) return state;  // nothing that is held moves with nodes
  const Eigen::VectorXd weights = weights_.tail(n) / sum;
  const Positions to = goals.bottomRows(n) + constants_;
  const Positions from = to - at.gaps.bottomRows(n);
  const Eigen::RowVector3d from_middle = weights.transpose() * from;
  const Eigen::RowVector3d to_middle = weights.transpose() * to;
  const Matrix3 covariance =
      (to.rowwise() - to_middle).transpose() * weights.asDiagonal() * (from.rowwise() - from_middle);
  const Matrix3 R = nearest_rotation(covariance, Matrix3::Identity());
  Positions result = state;
  for (int j = 0; j < state.rows() / kNodeRows; ++j) {
    if (is_erased_[static_cast<size_t>(j) * unknowns_->per_node()] != 0) continue;
    const Eigen::RowVector3d node = nodes_.row(j);
    rows_of(result, j).topRows<3>() = rows_of(state, j).topRows<3>() * R.transpose();
    rows_of(result, j).row(3) = to_middle + (node + rows_of(state, j).row(3) - from_middle) * R.transpose() - node;
  }
  return result;
}

Positions NewtonSteps::wanted(const Positions& targets) const {
  Positions result(n_edge_rows_ + targets.rows(), 3);
  result.topRows(n_edge_rows_) = edge_goals_;
  result.bottomRows(targets.rows()) = targets - constants_;
  return result;
}

NewtonSteps::Place NewtonSteps::place(const Positions& goals, Positions state) const {
  Positions gaps = rows_.gaps(goals, state, workers_);
  return {std::move(state), std::move(gaps)};
}

Positions NewtonSteps::seen(const Place& at) const {
  Positions gaps = at.gaps;
  gaps.bottomRows(learned_.moves.rows()) += learned_.moves;
  return gaps;
}

double NewtonSteps::cost(const Positions& state, const Positions& gaps) const {
  return unknowns_->energy(state) + weights_.dot(gaps.rowwise().squaredNorm());
}

double NewtonSteps::energy(const Place& at) const {
  double sum = unknowns_->energy(at.state);
  for (Eigen::Index r = 0; r < at.gaps.rows(); ++r)
    if (r < n_edge_rows_ || is_hard_[r - n_edge_rows_] == 0) sum += weights_[r] * at.gaps.row(r).squaredNorm();
  return sum;
}

NewtonSteps::Step NewtonSteps::step(const Positions& goals, Place& at) {
  constexpr int kMostHalvings = 30;
  const Positions gaps = seen(at);
  const double before = cost(at.state, gaps);
  // All gaps may be wrong by their rounding: so much the root of the cost, and of what a step promises.
  const double rounding = kRounding * std::sqrt(weights_.dot(goals.rowwise().squaredNorm()));
  const double highest = std::pow(std::sqrt(before) + rounding, 2);
  Positions of_state = Positions::Zero(at.state.rows(), 3);
  rows_.add_transposed(weights_.asDiagonal() * -gaps, of_state, workers_);
  const Eigen::VectorXd gradient = unknowns_->gradient(at.state, of_state);
  while (true) {
    const bool is_new = !factor_ || is_stale_;
    if (is_new) factorize(at.state, of_state);
    const Eigen::VectorXd change = solve_for(gradient);
    const double promise = -gradient.dot(change);
    Step taken;
    taken.whole = movement(at.state, unknowns_->stepped(at.state, change));
    taken.is_lost = promise <= rounding * rounding;
    double length = 1;
    for (int k = 0; !taken.is_lost && k < kMostHalvings; ++k, length /= 2) {
      Place next = place(goals, unknowns_->stepped(at.state, length * change));
      if (!(cost(next.state, seen(next)) <= highest)) continue;
      // A step that had to be cut wants the matrix of where it ends.
      is_stale_ = k > 0;
      taken.moved = movement(at.state, next.state);
      at = std::move(next);
      return taken;
    }
    is_stale_ = !is_new;
    if (is_stale_) continue;
    taken.is_lost = taken.is_lost || length * promise <= highest - before;
    if (!taken.is_lost) throw SolverError("no step lowers the energy; look for targets far away");
    return taken;
  }
}

void NewtonSteps::factorize(const Positions& state, const Positions& of_state) {
  using Curvature = NodeUnknowns::Curvature;
  ++n_factorizations_;
  try {
    factor_ = solver_->factorize(unknowns_->matrix(state, of_state, Curvature::kWhole), is_erased_);
  } catch (const NotPositiveDefinite&) {
    ++n_factorizations_;
    factor_ = solver_->factorize(unknowns_->matrix(state, of_state, Curvature::kNotNegative), is_erased_);
  }
}

Eigen::VectorXd NewtonSteps::solve_for(const Eigen::VectorXd& gradient) const {
  // The solver has three right-hand sides; here it needs one.
  Positions change = Positions::Zero(gradient.size(), 3);
  for (Eigen::Index k = 0; k < gradient.size(); ++k)
    if (is_erased_[k] == 0) change(k, 0) = -gradient[k];
  factor_->solve(change);
  return change.col(0);
}

double NewtonSteps::largest_gap(const Place& at) const {
  double largest = 0;
  for (Eigen::Index r = 0; r < learned_.moves.rows(); ++r)
    if (is_hard_[r] != 0) largest = std::max(largest, at.gaps.row(n_edge_rows_ + r).norm());
  return largest;
}

void NewtonSteps::learn(const Place& at, double gap) {
  learned_.is_all = gap > kLearning * learned_.gap || learned_.times++ == kMostLearnings;
  learned_.gap = gap;
  if (learned_.is_all) return;
  for (Eigen::Index r = 0; r < learned_.moves.rows(); ++r)
    if (is_hard_[r] != 0) learned_.moves.row(r) += at.gaps.row(n_edge_rows_ + r);
}

void NewtonSteps::forget() noexcept {
  forget_multipliers();
  factor_ = nullptr;
}

void NewtonSteps::forget_multipliers() noexcept {
  learned_.moves.setZero();
  learned_.gap = std::numeric_limits<double>::infinity();
  learned_.times = 0;
  learned_.is_all = false;
}

double NewtonSteps::movement(const Positions& from, const Positions& to) const {
  double largest = 0;
  for (Eigen::Index j = 0; j < from.rows() / kNodeRows; ++j) {
    const auto change = to.middleRows<kNodeRows>(kNodeRows * j) - from.middleRows<kNodeRows>(kNodeRows * j);
    largest = std::max(largest, change.row(3).norm() + node_distance_ * change.topRows<3>().norm());
  }
  return largest;
}

}  // namespace arap
