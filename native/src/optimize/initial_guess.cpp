// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/initial_guess.h"

#include <algorithm>

#include "base/eigen_compat.h"
#include "cholesky/preconditioned_cg.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Relative accuracy of the rotations of the guess, as they differ in a part.
constexpr double kRotationAccuracy = 1e-3;

/// Mean rotation vector of what is constrained in each part, part -1 (isolated vertices) first.
/// @param rotations  (n_targets, 3)
std::vector<Eigen::RowVector3d> mean_rotations(const PreparedModel& model, const PreparedConstraints& constraints,
                                               const Positions& rotations) {
  std::vector<Eigen::RowVector3d> sums(model.n_parts + 1, Eigen::RowVector3d::Zero());
  std::vector<int> counts(sums.size(), 0);
  for (Eigen::Index k = 0; k < rotations.rows(); ++k) {
    const int place = model.part_of_vertex[constraints.vertex_of_target[k]] + 1;
    sums[place] += rotations.row(k);
    ++counts[place];
  }
  for (size_t place = 0; place < sums.size(); ++place) sums[place] /= std::max(1, counts[place]);
  return sums;
}

/// What the rotations of held rows lack, by a field of rotations at the unknowns: with regions, members have theirs.
auto gaps_of_held(const PreparedConstraints& constraints, const Positions& targets, const Positions& field,
                  const Workers& workers) {
  const Positions of_held = constraints.held_targets(targets);
  if (constraints.regions.empty()) return constraints.held_gaps(of_held, field, workers);
  Positions of_members = field;
  constraints.regions.expand(of_members);
  return constraints.held_gaps(of_held, of_members, workers);
}

}  // namespace

void guess_naive_laplacian(const PreparedModel& model, PreparedConstraints& constraints, const Positions& targets,
                           const Positions& vertex_targets, Pose& pose) {
  const ConstrainedSystem& system = constraints.laplacian_system(model);
  const RigidRegions& regions = constraints.regions;
  Positions gap = model.rest - pose.positions;
  Positions laplacian;
  Positions residual;
  multiply(model.energy.K, gap, laplacian, model.workers);
  multiply(model.energy.K, laplacian, residual, model.workers);
  const Eigen::VectorXd diagonal = model.energy.K.diagonal();
  const Eigen::VectorXd& soft = constraints.soft_diagonal;
  for (Eigen::Index v = 0; v < soft.size(); ++v) {
    if (!(soft[v] > 0)) continue;
    const double diagonal_squared = model.energy.K.col(v).squaredNorm();
    residual.row(v) += soft[v] * diagonal_squared / diagonal[v] * (vertex_targets.row(v) - pose.positions.row(v));
  }
  const PreparedConstraints::Rows& rows = constraints.soft_rows;
  const LinearRows weighted = PreparedConstraints::laplacian_rows(rows.rows, diagonal);
  const Positions row_gaps = rows.matrix.gaps(targets(rows.target_rows, all), pose.positions, model.workers);
  rows.matrix.add_transposed(weighted.weight_vector().asDiagonal() * row_gaps, residual, model.workers);
  regions.reduce(residual);
  const Positions gaps = constraints.held_gaps(constraints.held_targets(targets), pose.positions, model.workers);
  system.correct_to(kDoubleAccuracy, residual, gaps);
  regions.expand(residual);
  pose.positions += residual;
  regions.read_translations(pose.placements, pose.positions);
}

double guess_accuracy(double range) {
  constexpr double kOfOneRotation = 1e-7;
  constexpr double kOfARadian = 1e-5;
  return std::clamp(kOfARadian * range, kOfOneRotation, kOfARadian);
}

double spread_rotations(const PreparedModel& model, const PreparedConstraints& constraints, const Positions& rotations,
                        Pose& pose) {
  const ConstrainedSystem& system = constraints.system();
  const RigidRegions& regions = constraints.regions;
  // A row whose coefficients sum to s has s times the rotation vector that its unknowns should have.
  const Positions targets = constraints.target_sums.asDiagonal() * rotations;
  Positions of_vertex = Positions::Zero(model.rest.rows(), 3);
  constraints.write_vertex_targets(targets, of_vertex);
  // From the mean of a part the way to its rotations is short, and none if all of them are one.
  const std::vector<Eigen::RowVector3d> means = mean_rotations(model, constraints, rotations);
  Positions field = Positions::Zero(model.rest.rows(), 3);
  for (Eigen::Index v = 0; v < field.rows(); ++v)
    field.row(regions.unknown_of(static_cast<int>(v))) = means[model.part_of_vertex[v] + 1];
  for (const int v : constraints.hard_vertices) field.row(regions.unknown_of(v)) = of_vertex.row(v);
  const Positions of_anchors = constraints.anchor_targets(rotations);
  for (size_t k = 0; k < constraints.anchor_points.size(); ++k)
    field.row(regions.unknown(constraints.anchor_points[k].region)) = of_anchors.row(static_cast<Eigen::Index>(k));
  Positions residual;
  system.multiply(field, residual);
  residual = -residual;
  const PreparedConstraints::Rows& rows = constraints.soft_rows;
  rows.matrix.add_transposed(rows.rows.weight_vector().asDiagonal() * targets(rows.target_rows, all), residual,
                             model.workers);
  regions.reduce(residual);
  for (const int v : constraints.soft_vertices)
    residual.row(regions.unknown_of(v)) += constraints.soft_diagonal[v] * of_vertex.row(v);
  of_vertex.resize(0, 3);
  system.correct_to(kRotationAccuracy, residual, gaps_of_held(constraints, targets, field, model.workers));
  const double range = longest_row(residual, model.workers);
  field += residual;

  const auto rotation_at = [&](int unknown) {
    const double angle = field.row(unknown).norm();
    if (!(angle > 0)) return Eigen::Quaterniond::Identity();
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, field.row(unknown).transpose() / angle));
  };
  parallel_for(model.workers, model.energy.n_cells(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c)
      if (const int home = model.energy.cells.home(c); home >= 0)
        pose.rotations[c] = rotation_at(regions.unknown_of(home)) * pose.rotations[c];
  });
  for (int r = 0; r < regions.size(); ++r) {
    Matrix3& rotation = pose.placements[r].rotation;
    if (!regions.is_anchored(r)) rotation = rotation_at(regions.unknown(r)).toRotationMatrix() * rotation;
  }
  regions.write(pose.placements, pose.positions);
  regions.share_rotations(pose.placements, pose.rotations);
  return range;
}

}  // namespace arap
