// SPDX-License-Identifier: GPL-3.0-or-later
#include "local_global.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace arap {

namespace {

/// Decreases of the energy below this part of E_0 are rounding.
constexpr double kEnergyRounding = 1e-14;

double largest_row(const Positions& x) { return std::sqrt(x.rowwise().squaredNorm().maxCoeff()); }

double inner_product(const Positions& a, const Positions& b) { return a.cwiseProduct(b).sum(); }

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
  return largest_row(pose.positions - before) > kMoved;
}

Positions LocalGlobal::patch_gaps(const Positions& positions) const {
  Positions gaps = patch_targets_;
  for (Eigen::Index k = 0; k < gaps.rows(); ++k) gaps.row(k) -= constraints_.patches()[k].of(positions);
  return gaps;
}

void LocalGlobal::find_correction(const Positions& gaps, Positions& correction) {
  const RigidRegions& regions = constraints_.regions();
  correction = residual_;
  regions.reduce(correction);
  constraints_.system().correct(correction, gaps, multipliers_);
  regions.expand(correction);
}

void LocalGlobal::apply_residual_exactly(Pose& pose) {
  const RigidRegions& regions = constraints_.regions();
  regions.reduce(residual_);
  constraints_.system().correct_exactly(residual_, patch_gaps(pose.positions));
  regions.expand(residual_);
  pose.positions += residual_;
  regions.read_translations(pose.placements, pose.positions);
}

void LocalGlobal::project_on_patches(Pose& pose) {
  if (patch_targets_.rows() == 0) return;
  residual_ = Positions::Zero(pose.positions.rows(), 3);
  apply_residual_exactly(pose);
}

double LocalGlobal::refresh_residual(const Pose& pose) {
  double energy = model_.energy.rest_energy + model_.passes->find_residual(pose.rotations, residual_);
  const Eigen::VectorXd& soft = constraints_.soft_diagonal();
  for (const int v : constraints_.soft_vertices()) {
    const Eigen::RowVector3d gap = targets_.vertices.row(v) - pose.positions.row(v);
    energy += 0.5 * soft[v] * gap.squaredNorm();
    residual_.row(v) += soft[v] * gap;
  }
  return std::max(0.0, energy);  // no energy here is negative; rounding may be
}

double LocalGlobal::fit(Pose& pose) {
  model_.passes->set_positions(pose.positions);
  model_.passes->fit_rotations(pose.rotations);
  const RigidRegions& regions = constraints_.regions();
  if (!regions.empty()) {
    regions.share_rotations(pose.placements, pose.rotations);
    regions.fit_rotations(targets_, constraints_.soft_diagonal(), constraints_.patches(), multipliers_, pose.placements,
                          pose.rotations, pose.positions);
    if (constraints_.has_mixed_patches()) project_on_patches(pose);
    model_.passes->set_positions(pose.positions);
  }
  return refresh_residual(pose);
}

void LocalGlobal::global_step(Pose& pose) {
  model_.passes->set_positions(pose.positions);
  static_cast<void>(refresh_residual(pose));
  apply_residual_exactly(pose);
}

double LocalGlobal::try_step(Pose& pose, double length, const Search& search) {
  pose.positions = search.start + length * search.direction;
  pose.placements = search.placements;
  constraints_.regions().read_translations(pose.placements, pose.positions);
  return fit(pose);
}

// Nonlinear conjugate gradients on E(p') = min_R E(p', R), preconditioned by the factorized matrix. The preconditioned
// residual z is the global step, so with beta = 0 and length 1 this is plain local/global, which never raises the
// energy: it is the first step, and the way out wherever a longer one raises it. beta by Polak and Ribiere, not below
// 0; the length by the secant of the slope at 0 and at the last length.
double LocalGlobal::iterate(Pose& pose, double energy, Search& search) {
  constexpr double kLongest = 4;
  constexpr double kShortest = 0.25;
  constexpr double kSecondLook = 0.3;  // relative change of the length that is worth another evaluation
  find_correction(patch_gaps(pose.positions), search.correction);
  const double z_r = inner_product(search.correction, residual_);
  const double beta =
      search.is_fresh ? 0 : std::max(0.0, (z_r - inner_product(search.correction, search.residual)) / search.z_r);
  if (beta > 0)
    search.direction = search.correction + beta * search.direction;
  else
    search.direction = search.correction;
  double slope = beta > 0 ? inner_product(search.direction, residual_) : z_r;
  if (!(slope > 0)) {
    search.direction = search.correction;
    slope = z_r;
  }
  std::swap(search.start, pose.positions);
  search.residual = residual_;
  search.placements = pose.placements;
  const double rounding = kEnergyRounding * model_.energy.rest_energy;

  double length = search.is_fresh ? 1 : search.length;
  double reached = try_step(pose, length, search);
  if (!search.is_fresh || reached > energy + rounding) {
    const double slope_there = inner_product(search.direction, residual_);
    double better = length * slope / (slope - slope_there);
    if (!(better > 0) || better > kLongest * length) better = kLongest * length;
    if (std::abs(better - length) > kSecondLook * length || reached > energy + rounding) {
      length = better;
      reached = try_step(pose, length, search);
    }
  }
  search.is_fresh = false;
  if (reached > energy + rounding) {
    length = 1;
    search.direction = search.correction;
    search.is_fresh = true;
    reached = try_step(pose, length, search);
  }
  search.length = std::clamp(length, kShortest, kLongest);
  search.z_r = z_r;
  return reached;
}

IterationReport LocalGlobal::run(Pose& pose, const SolveOptions& options, const Progress& progress) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const double rounding = kEnergyRounding * model_.energy.rest_energy;
  IterationReport report;
  report.energy_before = report.energy_after = fit(pose);
  Search search;
  while (report.iterations < options.max_iterations) {
    const double fraction = static_cast<double>(report.iterations) / options.max_iterations;
    if (progress && !progress(fraction)) {
      report.stop_reason = StopReason::kCancelled;
      return report;
    }
    const double energy = iterate(pose, report.energy_after, search);
    ++report.iterations;
    report.step = std::max(largest_row(pose.positions - search.start), largest_row(search.correction));
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
