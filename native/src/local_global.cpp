// SPDX-License-Identifier: GPL-3.0-or-later
#include "local_global.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "parallel.h"

namespace arap {

namespace {

/// Decreases of the energy below this part of E_0 are rounding.
constexpr double kEnergyRounding = 1e-14;

double largest_movement(const Positions& a, const Positions& b) {
  return std::sqrt((a - b).rowwise().squaredNorm().maxCoeff());
}

}  // namespace

LocalGlobal::LocalGlobal(const BoundModel& model, const BoundConstraints& constraints, const Positions& targets)
    : model_(model),
      constraints_(constraints),
      targets_{constraints.vertex_targets(targets), constraints.anchor_targets(targets)},
      patch_targets_(constraints.patch_targets(targets)),
      multipliers_(Positions::Zero(patch_targets_.rows(), 3)) {}

bool LocalGlobal::impose_constraints(Pose& pose) const {
  // Of a mesh of size 1: far above rounding, far below what could turn a rotation.
  constexpr double kMoved = 1e-12;
  const Positions before = pose.positions;
  for (Eigen::Index v = 0; v < pose.positions.rows(); ++v) {
    if (constraints_.is_hard()[v] != 0)
      pose.positions.row(v) = targets_.vertices.row(v);
    else if (constraints_.is_at_rest()[v] != 0)
      pose.positions.row(v) = model_.rest.row(v);
  }
  const RigidRegions& regions = constraints_.regions();
  for (int r = 0; r < regions.size(); ++r)
    if (constraints_.is_at_rest()[regions.unknown(r)] != 0) pose.placements[r] = regions.rest_placement(r);
  regions.place_anchored(targets_, pose.placements);
  regions.write(pose.placements, pose.positions);
  return largest_movement(pose.positions, before) > kMoved;
}

Positions LocalGlobal::patch_gaps(const Positions& positions) const {
  Positions gaps = patch_targets_;
  for (Eigen::Index k = 0; k < gaps.rows(); ++k) gaps.row(k) -= constraints_.patches()[k].of(positions);
  return gaps;
}

void LocalGlobal::apply_residual(Pose& pose) {
  const RigidRegions& regions = constraints_.regions();
  regions.reduce(residual_);
  constraints_.system().correct(residual_, patch_gaps(pose.positions), multipliers_);
  regions.expand(residual_);
  pose.positions += residual_;
  regions.read_translations(pose.placements, pose.positions);
}

void LocalGlobal::project_on_patches(Pose& pose) {
  if (patch_targets_.rows() == 0) return;
  residual_ = Positions::Zero(pose.positions.rows(), 3);
  multipliers_.setZero();
  apply_residual(pose);
  multipliers_.setZero();
}

double LocalGlobal::refresh_residual(const Pose& pose) {
  const CellEnergy& energy = model_.energy;
  const Positions& p = pose.positions;
  energy.right_hand_side(pose.rotations, right_hand_side_, model_.threads);
  multiply(energy.K, p, residual_, model_.threads);
  const Eigen::VectorXd& soft = constraints_.soft_diagonal();
  const double sum = parallel_sum(model_.threads, static_cast<int>(p.rows()), [&](int begin, int end) {
    double part = 0;
    for (int v = begin; v < end; ++v) {
      part += p.row(v).dot(0.5 * residual_.row(v) - right_hand_side_.row(v));
      residual_.row(v) = right_hand_side_.row(v) - residual_.row(v);
      if (!(soft[v] > 0)) continue;
      const Eigen::RowVector3d gap = targets_.vertices.row(v) - p.row(v);
      part += 0.5 * soft[v] * gap.squaredNorm();
      residual_.row(v) += soft[v] * gap;
    }
    return part;
  });
  return std::max(0.0, sum + energy.rest_energy);  // no energy here is negative; rounding may be
}

double LocalGlobal::fit(Pose& pose) {
  model_.energy.fit_rotations(pose.positions, pose.rotations, model_.threads);
  const RigidRegions& regions = constraints_.regions();
  if (!regions.empty()) {
    regions.share_rotations(pose.placements, pose.rotations);
    regions.fit_rotations(targets_, constraints_.soft_diagonal(), constraints_.patches(), multipliers_, pose.placements,
                          pose.rotations, pose.positions);
    if (constraints_.has_mixed_patches()) {
      const Positions pulls = multipliers_;
      project_on_patches(pose);
      multipliers_ = pulls;
    }
  }
  return refresh_residual(pose);
}

void LocalGlobal::global_step(Pose& pose) {
  static_cast<void>(refresh_residual(pose));
  apply_residual(pose);
}

IterationReport LocalGlobal::run(Pose& pose, const SolveOptions& options, const Progress& progress) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const double rounding = kEnergyRounding * model_.energy.rest_energy;
  IterationReport report;
  report.energy_before = report.energy_after = fit(pose);
  while (report.iterations < options.max_iterations) {
    const double fraction = static_cast<double>(report.iterations) / options.max_iterations;
    if (progress && !progress(fraction)) {
      report.stop_reason = StopReason::kCancelled;
      return report;
    }
    const Positions previous = pose.positions;
    apply_residual(pose);
    const double energy = fit(pose);
    ++report.iterations;
    report.step = largest_movement(pose.positions, previous);
    const double decrease = report.energy_after - energy;
    report.energy_after = energy;
    if (decrease <= options.energy_tolerance * energy + rounding && report.step <= options.step_tolerance) {
      report.stop_reason = StopReason::kConverged;
      return report;
    }
    if (std::chrono::duration<double>(Clock::now() - start).count() >= options.time_limit_s) {
      report.stop_reason = StopReason::kTimeLimit;
      return report;
    }
  }
  return report;
}

}  // namespace arap
