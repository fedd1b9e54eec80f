// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/initial_guess.h"

#include <algorithm>

#include "parallel/parallel.h"

namespace arap {

namespace {

/// Of what turns of the guess differ by in a part.
constexpr double kTurnAccuracy = 1e-3;

/// Mean turn of what is constrained in each part, part -1 (loose vertices) first.
std::vector<Eigen::RowVector3d> mean_turns(const PreparedModel& model, const PreparedConstraints& constraints,
                                           const Positions& turn_of_vertex, const Positions& turns) {
  std::vector<Eigen::RowVector3d> sums(model.n_parts + 1, Eigen::RowVector3d::Zero());
  std::vector<int> counts(sums.size(), 0);
  const auto add = [&](int v, const Eigen::RowVector3d& turn) {
    const int place = model.part_of_vertex[v] + 1;
    sums[place] += turn;
    ++counts[place];
  };
  const auto add_patches = [&](const std::vector<Average>& patches, const std::vector<int>& rows) {
    for (size_t k = 0; k < patches.size(); ++k) add(patches[k].indices.front(), turns.row(rows[k]));
  };
  for (const int v : constraints.hard_vertices()) add(v, turn_of_vertex.row(v));
  for (const int v : constraints.soft_vertices()) add(v, turn_of_vertex.row(v));
  add_patches(constraints.patches(), constraints.patch_rows());
  add_patches(constraints.anchor_patches(), constraints.anchor_rows());
  for (size_t place = 0; place < sums.size(); ++place) sums[place] /= std::max(1, counts[place]);
  return sums;
}

}  // namespace

void guess_naive_laplacian(const PreparedModel& model, PreparedConstraints& constraints,
                           const Positions& vertex_targets, const Positions& patch_targets, Pose& pose) {
  const ConstrainedSystem& system = constraints.laplacian_system(model);
  const RigidRegions& regions = constraints.regions();
  Positions gap = model.rest - pose.positions;
  Positions laplacian;
  Positions residual;
  multiply(model.energy.K, gap, laplacian, model.workers);
  multiply(model.energy.K, laplacian, residual, model.workers);
  const Eigen::VectorXd diagonal = model.energy.K.diagonal();
  const Eigen::VectorXd& soft = constraints.soft_diagonal();
  for (Eigen::Index v = 0; v < soft.size(); ++v) {
    if (!(soft[v] > 0)) continue;
    const double diagonal_squared = model.energy.K.col(v).squaredNorm();
    residual.row(v) += soft[v] * diagonal_squared / diagonal[v] * (vertex_targets.row(v) - pose.positions.row(v));
  }
  regions.reduce(residual);
  system.correct_to(kDoubleAccuracy, residual, gaps_to(patch_targets, constraints.patches(), pose.positions));
  regions.expand(residual);
  pose.positions += residual;
  regions.read_translations(pose.placements, pose.positions);
}

double guess_accuracy(double turn_range) {
  constexpr double kOfOneTurn = 1e-7;
  constexpr double kOfARadian = 1e-5;
  return std::clamp(kOfARadian * turn_range, kOfOneTurn, kOfARadian);
}

double spread_rotations(const PreparedModel& model, const PreparedConstraints& constraints, const Positions& turns,
                        Pose& pose) {
  const ConstrainedSystem& system = constraints.system();
  const RigidRegions& regions = constraints.regions();
  Positions turn_of_vertex = Positions::Zero(model.rest.rows(), 3);
  constraints.write_vertex_targets(turns, turn_of_vertex);
  // From the mean of a part the way to its turns is short, and none where all of them are one.
  const std::vector<Eigen::RowVector3d> means = mean_turns(model, constraints, turn_of_vertex, turns);
  Positions field(model.rest.rows(), 3);
  for (Eigen::Index v = 0; v < field.rows(); ++v)
    field.row(regions.unknown_of(static_cast<int>(v))) = means[model.part_of_vertex[v] + 1];
  for (const int v : constraints.hard_vertices()) field.row(regions.unknown_of(v)) = turn_of_vertex.row(v);
  for (size_t k = 0; k < constraints.anchor_patches().size(); ++k)
    field.row(regions.unknown_of(constraints.anchor_patches()[k].indices.front())) =
        turns.row(constraints.anchor_rows()[k]);
  Positions pull;
  multiply(system.matrix(), field, pull, model.workers);
  Positions residual = -pull;
  for (const int v : constraints.soft_vertices())
    residual.row(regions.unknown_of(v)) += constraints.soft_diagonal()[v] * turn_of_vertex.row(v);
  system.correct_to(kTurnAccuracy, residual, gaps_to(constraints.patch_targets(turns), system.averages(), field));
  const double turn_range = longest_row(residual, model.workers);
  field += residual;

  const auto turn_at = [&](int unknown) {
    const double angle = field.row(unknown).norm();
    if (!(angle > 0)) return Eigen::Quaterniond::Identity();
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, field.row(unknown).transpose() / angle));
  };
  parallel_for(model.workers, model.energy.n_cells(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c)
      if (const int home = model.energy.home(c); home >= 0)
        pose.rotations[c] = turn_at(regions.unknown_of(home)) * pose.rotations[c];
  });
  for (int r = 0; r < regions.size(); ++r) {
    Matrix3& rotation = pose.placements[r].rotation;
    if (!regions.is_anchored(r)) rotation = turn_at(regions.unknown(r)).toRotationMatrix() * rotation;
  }
  regions.write(pose.placements, pose.positions);
  regions.share_rotations(pose.placements, pose.rotations);
  return turn_range;
}

}  // namespace arap
