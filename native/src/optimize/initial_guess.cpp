// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/initial_guess.h"

#include <algorithm>

#include "base/eigen_compat.h"
#include "cholesky/preconditioned_cg.h"
#include "geometry/rotation_vectors.h"
#include "optimize/harmonic_field.h"

namespace arap {

namespace {

/// Relative accuracy of the rotations of the guess, as they differ in a part.
constexpr double kRotationAccuracy = 1e-3;

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
  const auto [field, range] = interpolate_harmonically(model, constraints, rotations, kRotationAccuracy);
  turn_cells(
      model, constraints, [&field = field](int unknown) { return rotation_by(field.row(unknown).transpose()); }, pose);
  return range;
}

}  // namespace arap
