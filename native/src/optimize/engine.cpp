// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/engine.h"

#include <cmath>
#include <utility>

#include "arap/error.h"
#include "base/available_memory.h"
#include "optimize/initial_guess.h"
#include "optimize/time_budget.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Fits the rotations to positions that have nothing to do with the former ones; returns the sum of <R_c, Q_c>.
double fit_from_rest(CellPasses& passes, const Positions& positions) {
  passes.set_positions(positions);
  passes.reset_rotations();
  return passes.fit_rotations();
}

}  // namespace

Engine::Engine(const PreparedModel& model) : model_(model), pose_(at_rest()) {}

Pose Engine::at_rest() const {
  return {model_.rest, Rotations(n_cells(), Eigen::Quaterniond::Identity()),
          model_.regions.fit_placements(model_.rest)};
}

void Engine::move_to_rest() {
  steps_->forget_pose();
  pose_.positions = model_.rest;
  pose_.rotations.assign(n_cells(), Eigen::Quaterniond::Identity());
  pose_.placements = model_.regions.fit_placements(pose_.positions);
}

Pose Engine::fitted(Positions positions) {
  if (steps_ != nullptr) steps_->forget();
  CellPasses& fitting = passes(Precision::kSingle);
  static_cast<void>(fit_from_rest(fitting, positions));
  Pose pose;
  fitting.read_rotations(pose.rotations);
  pose.positions = std::move(positions);
  return pose;
}

void Engine::take(Pose pose) noexcept {
  if (steps_ != nullptr) steps_->forget_pose();
  kept_ = std::exchange(pose_, std::move(pose));
  last_targets_.resize(0, 3);
}

void Engine::end_search() noexcept {
  search_ = nullptr;
  steps_ = nullptr;
}

void Engine::require_search() {
  if (search_ != nullptr) return;
  steps_ = std::make_unique<LocalGlobal>(model_, *constraints_);
  search_ = std::make_unique<NonlinearCg>(*steps_);
}

void Engine::make_room() {
  end_search();
  predictor_.forget();
  kept_ = {};
  model_.drop_passes();
  if (has_constraints()) constraints_->drop_passes();
  return_freed_memory();  // of a change that failed, too
}

Engine::Change Engine::prepare(const ModelConstraints& given, const Progress& progress) {
  if (model_.is_large()) make_room();
  Change change;
  change.constraints = std::make_unique<PreparedConstraints>(model_, given, progress);
  change.handle_rotations = std::make_unique<HandleRotations>(model_, *change.constraints);
  change.rotations = rotations_for(*change.constraints);
  return change;
}

Rotations Engine::rotations_for(const PreparedConstraints& constraints) const {
  const std::span<const int> origins = constraints.split_origins();
  const auto n = model_.energy.n_cells();
  Rotations rotations(pose_.rotations.begin(), pose_.rotations.begin() + n);
  rotations.reserve(rotations.size() + origins.size());
  for (const int cell : origins) rotations.push_back(pose_.rotations[cell]);
  return rotations;
}

void Engine::take(Change change) noexcept {
  end_search();
  handle_rotations_ = std::move(change.handle_rotations);
  constraints_ = std::move(change.constraints);
  pose_.rotations.swap(change.rotations);
  kept_ = {};  // what it was is in other cells
  if (!constraints_->split_origins().empty()) model_.drop_passes();
  last_targets_.resize(0, 3);
  ++n_factorizations_;
  if (model_.is_large()) return_freed_memory();
}

double Engine::evaluate(const Positions& positions, Positions& gradient) {
  if (steps_ != nullptr) steps_->forget();
  CellPasses& fitting = passes(Precision::kDouble);
  double alignment = fit_from_rest(fitting, positions);
  Positions of_rotations = Positions::Zero(positions.rows(), 3);
  if (!model_.regions.empty()) {
    const RigidRegions& regions = has_constraints() ? constraints_->regions : model_.regions;
    Rotations rotations;
    fitting.read_rotations(rotations);
    of_rotations = regions.turn_cells(positions, rotations);
    fitting.set_rotations(rotations);
    alignment = fitting.alignment();
  }
  const double energy = fitting.rest_energy() + fitting.find_residual(gradient) - alignment;
  gradient = of_rotations - gradient;
  return energy < 0 ? 0 : energy;
}

void Engine::keep_pose() {
  copy_rows(model_.workers, pose_.positions, kept_.positions);
  kept_.rotations = pose_.rotations;
}

void Engine::restore_pose() noexcept {
  if (steps_ != nullptr) steps_->forget_pose();
  pose_.positions.swap(kept_.positions);
  pose_.rotations.swap(kept_.rotations);
}

void Engine::undo() noexcept {
  restore_pose();
  predictor_.forget();
  last_targets_.resize(0, 3);
}

Precision Engine::first_precision(const Positions& targets, const SolveOptions& options, bool goes_on_there) const {
  // A search that has come to double stays there, although a single estimate may be of a greater distance again.
  const bool is_near_end = goes_on_there && (needs_double(search_->distance(), options.accuracy) ||
                                             (steps_->is_in_double() && ends_in_double(options.accuracy)));
  if (is_near_end || constraints_->is_weak_hold) return Precision::kDouble;
  // Single if it can tell the edges of the mesh beside its whole extent.
  constexpr double kFinest = 1e-7;
  const bool is_coarse = options.accuracy >= kFinest;
  const bool is_in_reach = targets.size() == 0 || targets.cwiseAbs().maxCoeff() <= kSinglePrecisionReach;
  return is_coarse && is_in_reach ? Precision::kSingle : Precision::kDouble;
}

Engine::Start Engine::plan(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations) {
  Start start;
  start.goes_on = options.initial_guess == InitialGuess::kPrevious && last_targets_.rows() > 0;
  start.goes_on_there = start.goes_on && last_targets_ == targets && steps_->knows_pose();
  start.rotations =
      handle_rotations_->of_start(options.initial_guess, last_targets_, pose_.positions, targets, rotations);
  if (start.goes_on) start.step = targets - last_targets_;
  if (start.rotations.rows() == 0 && !keeps_volumes()) start.ahead = predictor_.share(start.step);
  return start;
}

std::optional<double> Engine::apply_guess(const Positions& targets, InitialGuess guess, const Start& start) {
  if (guess != InitialGuess::kPrevious) move_to_rest();
  // The centers of rigid regions depend on the constraints.
  pose_.placements = constraints_->regions.fit_placements(pose_.positions);
  const bool has_torn = steps_->impose_constraints(pose_);
  if (guess == InitialGuess::kNaiveLaplacian) {
    const bool is_first = !constraints_->has_laplacian_system();
    guess_naive_laplacian(model_, *constraints_, targets, steps_->vertex_targets(), pose_);
    if (is_first) ++n_factorizations_;
  }
  // With the rotations of the former pose: fitted to a torn one, they would rotate what a single handle only moves.
  if (start.rotations.rows() > 0) {
    const double range = spread_rotations(model_, *constraints_, start.rotations, pose_);
    steps_->forget();
    // Brings the patches to their targets too, as the plain one does.
    steps_->global_step_to(guess_accuracy(range), pose_);
    return std::nullopt;
  }
  if (start.ahead != 0) return steps_->global_step(pose_, predictor_, start.ahead);
  if (guess == InitialGuess::kPrevious && (has_torn || (start.step.array() != 0).any()))
    return steps_->global_step(pose_);
  steps_->project_on_held(pose_);
  return std::nullopt;
}

void Engine::learn(Positions targets, const Start& start) {
  // If the targets were at rest there is nothing to learn.
  if (start.is_drag() && !keeps_volumes())
    predictor_.learn(start.step, model_.workers);
  else if (!start.goes_on || start.rotations.rows() > 0)
    predictor_.forget();
  last_targets_.swap(targets);
}

IterationReport Engine::solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                              const Progress& progress, const HandOver& hand_over) {
  TimeBudget time(options.time_limit_s);
  require_search();
  const Start start = plan(targets, options, rotations);
  keep_pose();
  IterationReport report;
  try {
    steps_->set_targets(targets, first_precision(targets, options, start.goes_on_there));
    time.begin_iteration();
    const std::optional<double> step = apply_guess(targets, options.initial_guess, start);
    if (!start.goes_on)
      search_->forget();
    else if (step || !start.goes_on_there)
      search_->restart();
    report = minimize(*steps_, *search_, pose_, options, progress, time, step, [&] {
      if (start.is_drag() && !keeps_volumes()) steps_->show_forces_to(predictor_, start.ahead);
    });
    const bool is_cancelled = report.stop_reason == StopReason::kCancelled;
    const bool is_good = is_cancelled || (std::isfinite(report.energy_before) && std::isfinite(report.energy_after));
    if (!is_good || !hand_over(is_cancelled ? kept_.positions : pose_.positions))
      throw SolverError("the positions are no longer finite; the last good pose is kept");
    if (is_cancelled)
      restore_pose();
    else
      learn(targets, start);
  } catch (...) {
    predictor_.forget();
    restore_pose();
    throw;
  }
  return report;
}

}  // namespace arap
