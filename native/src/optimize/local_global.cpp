// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/local_global.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/eigen_compat.h"
#include "optimize/row_grain.h"
#include "parallel/parallel.h"

namespace arap {

void turn_cells(const PreparedModel& model, const PreparedConstraints& constraints, const RotationAt& rotation_at,
                Pose& pose) {
  const RigidRegions& regions = constraints.regions;
  const Cells& cells = constraints.cells(model);
  parallel_for(model.workers, model.energy.n_cells(cells), [&](int begin, int end) {
    for (int c = begin; c < end; ++c)
      if (const int home = model.energy.home(cells, c); home >= 0)
        pose.rotations[c] = rotation_at(regions.unknown_of(home)) * pose.rotations[c];
  });
  for (int r = 0; r < regions.size(); ++r) {
    Matrix3& rotation = pose.placements[r].rotation;
    if (!regions.is_anchored(r)) rotation = rotation_at(regions.unknown(r)).toRotationMatrix() * rotation;
  }
  regions.write(pose.placements, pose.positions);
  regions.share_rotations(pose.placements, pose.rotations);
}

double longest_row(const Positions& x, const Workers& workers) {
  const double squared = parallel_reduce<kRows>(
      workers, static_cast<int>(x.rows()), 0.0,
      [&](int begin, int end) { return x.middleRows(begin, end - begin).rowwise().squaredNorm().maxCoeff(); },
      [](double a, double b) { return std::max(a, b); });
  return std::sqrt(squared);
}

LocalGlobal::LocalGlobal(const PreparedModel& model, const PreparedConstraints& constraints)
    : model_(model), constraints_(constraints) {
  targets_.vertices = Positions::Zero(model.rest.rows(), 3);
}

void LocalGlobal::set_targets(const Positions& targets, Precision precision) {
  const bool knew_pose = knows_pose();
  const bool is_in_double = precision == Precision::kDouble || !model_.fits_single;
  if (passes_ == nullptr || is_in_double != is_in_double_) forget();
  passes_ = nullptr;  // those of a large model go before the others are made, which may fail
  passes_ = &constraints_.passes(model_, precision);
  is_in_double_ = is_in_double;
  reach_ = targets.size() == 0 ? 1 : std::max(1.0, targets.cwiseAbs().maxCoeff());
  const auto pull_softly = [&](double sign) {
    const Eigen::VectorXd& soft = constraints_.soft_diagonal;
    if (known_ != Known::kResidual) return;
    for (const int v : constraints_.soft_vertices) residual_.row(v) += sign * soft[v] * targets_.vertices.row(v);
  };
  pull_softly(-1);
  constraints_.write_vertex_targets(targets, targets_.vertices);
  pull_softly(1);
  Positions row_targets = targets(constraints_.soft_rows.target_rows, all);
  if (known_ == Known::kResidual && row_targets.rows() > 0) add_row_forces(row_targets - targets_.rows);
  targets_.rows = std::move(row_targets);
  targets_.patches = constraints_.anchor_targets(targets);
  Positions held_targets = constraints_.held_targets(targets);
  // A solve that only goes on keeps what holds the patches: at the minimum nothing is left to correct.
  const bool goes_on = knew_pose && held_targets.rows() == held_targets_.rows();
  if (!goes_on || held_targets != held_targets_) {
    const Eigen::Index n_patches = std::ssize(constraints_.patches);
    // What holds hard rows is found by iteration, which begins nearer from the last ones.
    if (multipliers_.rows() != held_targets.rows()) multipliers_ = Positions::Zero(held_targets.rows(), 3);
    multipliers_.topRows(n_patches).setZero();
  }
  held_targets_ = std::move(held_targets);
}

bool LocalGlobal::impose_constraints(Pose& pose) {
  // Of a mesh of size 1: far above rounding, far below what could turn a rotation.
  constexpr double kMoved = 1e-12;
  const RigidRegions& regions = constraints_.regions;
  bool has_moved = false;
  const auto move = [&](int v, const Eigen::RowVector3d& place) {
    const Eigen::RowVector3d step = place - pose.positions.row(v);
    has_moved = has_moved || step.squaredNorm() > kMoved * kMoved;
    if (known_ == Known::kResidual && !step.isZero(0)) follow_vertex(v, step);
    pose.positions.row(v) = place;
  };
  for (const int v : constraints_.hard_vertices)
    if (!regions.has_member(v)) move(v, targets_.vertices.row(v));
  for (const int v : constraints_.vertices_at_rest) move(v, model_.rest.row(v));
  for (int r = 0; r < regions.size(); ++r)
    if (constraints_.is_at_rest[regions.unknown(r)] != 0) pose.placements[r] = regions.rest_placement(r);
  regions.place_anchored(targets_, pose.placements);
  regions.for_each_place(pose.placements, move);
  return has_moved;
}

Positions LocalGlobal::held_gaps(const Positions& positions) const {
  return constraints_.held_gaps(held_targets_, positions, workers());
}

Positions LocalGlobal::mixed_gaps(const Positions& positions) const {
  return constraints_.mixed_gaps(held_targets_, positions);
}

void LocalGlobal::add_held_forces(double sign) {
  constraints_.add_held_forces(sign, multipliers_, workers(), residual_);
}

void LocalGlobal::add_free_forces(double sign) {
  if (multipliers_.rows() == 0) return;
  Positions forces = -multipliers_;
  const LinearRows& stiff = constraints_.stiff_rows.rows;
  if (!stiff.empty()) forces.bottomRows(stiff.size()) = stiff.weight_vector().asDiagonal() * stiff_gaps_;
  constraints_.add_held_forces(sign, forces, workers(), residual_);
}

void LocalGlobal::follow_vertex(int v, const Eigen::RowVector3d& step) {
  for (SparseMatrix::InnerIterator entry(model_.energy.K, v); entry; ++entry)
    residual_.row(entry.row()) -= entry.value() * step;
  const RowMatrix& rows = constraints_.soft_rows.matrix;
  if (rows.empty()) return;
  rows.for_rows_of(v, [&](int row, double of_v) {
    const Eigen::RowVector3d force = constraints_.soft_rows.rows.weights[row] * of_v * step;
    rows.for_unknowns_of(row, [&](int i, double coefficient) { residual_.row(i) -= coefficient * force; });
  });
}

double LocalGlobal::add_row_forces(const Positions& gaps) {
  const auto weights = constraints_.soft_rows.rows.weight_vector();
  constraints_.soft_rows.matrix.add_transposed(weights.asDiagonal() * gaps, residual_, workers());
  return 0.5 * weights.dot(gaps.rowwise().squaredNorm());
}

void LocalGlobal::find_correction(const Pose& pose, Positions& correction) {
  const RigidRegions& regions = constraints_.regions;
  const ConstrainedSystem& system = constraints_.system();
  if (regions.empty()) {
    system.correct(residual_, held_gaps(pose.positions), multipliers_, correction);
    return;
  }
  const Positions of_members = regions.member_rows(residual_);
  regions.reduce(residual_);
  system.correct(residual_, held_gaps(pose.positions), multipliers_, correction);
  if (&correction != &residual_) regions.set_member_rows(of_members, residual_);
  regions.expand(correction);
}

void LocalGlobal::apply_residual_to(double accuracy, Pose& pose) {
  constraints_.regions.reduce(residual_);
  constraints_.system().correct_to(accuracy, residual_, held_gaps(pose.positions));
  add_correction(pose);
}

void LocalGlobal::add_correction(Pose& pose) {
  known_ = std::min(known_, Known::kRotations);
  constraints_.regions.expand(residual_);
  pose.positions += residual_;
  follow_positions(pose);
}

void LocalGlobal::project_on_held(Pose& pose) {
  if (held_targets_.rows() == 0) return;
  residual_ = Positions::Zero(pose.positions.rows(), 3);
  Positions multipliers;
  constraints_.system().correct(residual_, held_gaps(pose.positions), multipliers, residual_);
  add_correction(pose);
}

double LocalGlobal::refresh_residual(const Pose& pose) {
  double energy = passes_->rest_energy() + passes_->find_residual(residual_);
  const Eigen::VectorXd& soft = constraints_.soft_diagonal;
  for (const int v : constraints_.soft_vertices) {
    const Eigen::RowVector3d gap = targets_.vertices.row(v) - pose.positions.row(v);
    energy += 0.5 * soft[v] * gap.squaredNorm();
    residual_.row(v) += soft[v] * gap;
  }
  if (!constraints_.soft_rows.rows.empty())
    energy += add_row_forces(constraints_.soft_rows.matrix.gaps(targets_.rows, pose.positions, workers()));
  if (const LinearRows& stiff = constraints_.stiff_rows.rows; !stiff.empty()) {
    stiff_gaps_ = held_gaps(pose.positions).bottomRows(stiff.size());
    energy += 0.5 * stiff.weight_vector().dot(stiff_gaps_.rowwise().squaredNorm());
  }
  return energy;
}

double LocalGlobal::fit_regions(Pose& pose) {
  const RigidRegions& regions = constraints_.regions;
  const MixedPatches& mixed = constraints_.mixed_patches;
  regions.share_rotations(pose.placements, *passes_);
  Positions pulls;
  if (!mixed.empty()) {
    // What holds the patches may lag behind the cells by this fit: a turn by it could raise the energy.
    static_cast<void>(refresh_residual(pose));
    pulls = mixed.pulls(residual_);
  }
  for (int r = 0; r < regions.size(); ++r) {
    const Matrix3 before = pose.placements[r].rotation;
    Matrix3 pull = Matrix3::Zero();
    if (!mixed.empty()) pull = mixed.linear_term(r, before, mixed_gaps(pose.positions), pulls);
    regions.fit_rotation(r, targets_, constraints_.soft_diagonal, pull, pose.placements[r], *passes_, pose.positions);
    if (mixed.empty()) continue;
    mixed.follow_turn(r, pose.placements[r].rotation - before, pulls);
    if (!mixed.feels(r)) continue;
    mixed.close(mixed_gaps(pose.positions), pulls, pose.positions);
    follow_positions(pose);
  }
  if (mixed.empty()) return passes_->alignment_after(regions.cells_with_members());
  passes_->set_positions(pose.positions);
  return passes_->alignment();
}

double LocalGlobal::fit(Pose& pose) {
  passes_->set_positions(pose.positions);
  double alignment = passes_->fit_rotations();
  if (!constraints_.regions.empty()) alignment = fit_regions(pose);
  const double energy = refresh_residual(pose) - alignment;
  return energy < 0 ? 0 : energy;  // none is negative; rounding may be. What is not a number stays so.
}

LocalGlobal::Response LocalGlobal::respond(const Pose& pose, const Positions& residual, const RotationAt& rotation_at) {
  Pose turned = pose;
  turn_cells(model_, constraints_, rotation_at, turned);
  passes_->set_positions(turned.positions);
  passes_->set_rotations(turned.rotations);
  if (model_.energy.volume_stiffness > 0) static_cast<void>(passes_->alignment());  // finds the stresses
  static_cast<void>(refresh_residual(turned));
  Response response{residual_ - residual, {}};
  response.step = response.force;
  constraints_.regions.reduce(response.step);
  Positions multipliers;
  constraints_.system().correct(response.step, Positions::Zero(held_targets_.rows(), 3), multipliers, response.step);
  constraints_.regions.expand(response.step);
  return response;
}

void LocalGlobal::know_rotations(const Pose& pose) {
  if (known_ == Known::kNothing) passes_->set_rotations(pose.rotations);
  known_ = Known::kRotations;
}

void LocalGlobal::start(const Pose& pose) {
  know_rotations(pose);
  known_ = Known::kNothing;
}

void LocalGlobal::finish(Pose& pose) {
  passes_->read_rotations(pose.rotations);
  known_ = Known::kResidual;
}

bool LocalGlobal::go_on_in_double(Pose& pose) {
  if (is_in_double_) return false;
  passes_->read_rotations(pose.rotations);
  passes_ = &constraints_.passes(model_, Precision::kDouble);
  passes_->set_rotations(pose.rotations);
  is_in_double_ = true;
  return true;
}

void LocalGlobal::show_forces_to(DragPredictor& prediction, double share) {
  // What holds the patches is no force of the cells. Ahead it would change nothing, as new multipliers take it up; but
  // it would add up from frame to frame, and these numbers are rounded.
  add_held_forces(-1);
  prediction.observe(residual_, share, workers());
  add_held_forces(1);
}

void LocalGlobal::find_residual_of(const Pose& pose) {
  if (known_ == Known::kResidual) return;
  passes_->set_positions(pose.positions);
  know_rotations(pose);
  static_cast<void>(refresh_residual(pose));
}

double LocalGlobal::global_step(Pose& pose) {
  find_residual_of(pose);
  return apply_residual(pose);
}

double LocalGlobal::global_step(Pose& pose, const DragPredictor& prediction, double share) {
  find_residual_of(pose);
  prediction.add_to(residual_, share, workers());
  return apply_residual(pose);
}

void LocalGlobal::read_turned(const Positions& positions, Positions& rows) const {
  if (constraints_.mixed_patches.empty())
    rows = constraints_.regions.member_rows(positions);
  else
    copy_rows(workers(), positions, rows);
}

void LocalGlobal::begin_step(const Pose& pose) {
  if (!constraints_.regions.empty()) read_turned(pose.positions, start_);
}

double LocalGlobal::step_with_turns(const Pose& pose, double step) const {
  if (constraints_.regions.empty()) return step;
  Positions moved;
  read_turned(pose.positions, moved);
  const double with_turns = parallel_reduce<kRows>(
      workers(), static_cast<int>(moved.rows()), 0.0,
      [&](int begin, int end) {
        return (moved - start_).middleRows(begin, end - begin).rowwise().squaredNorm().maxCoeff();
      },
      [](double a, double b) { return std::max(a, b); });
  return std::max(step, std::sqrt(with_turns));
}

double LocalGlobal::apply_residual(Pose& pose) {
  begin_step(pose);
  find_correction(pose, residual_);
  known_ = Known::kRotations;
  const double squared = parallel_reduce<kRows>(
      workers(), static_cast<int>(residual_.rows()), 0.0,
      [&](int begin, int end) {
        const auto correction = residual_.middleRows(begin, end - begin);
        pose.positions.middleRows(begin, end - begin) += correction;
        return correction.rowwise().squaredNorm().maxCoeff();
      },
      [](double a, double b) { return std::max(a, b); });
  follow_positions(pose);
  return std::sqrt(squared);
}

void LocalGlobal::global_step_to(double accuracy, Pose& pose) {
  find_residual_of(pose);
  apply_residual_to(accuracy, pose);
}

}  // namespace arap
