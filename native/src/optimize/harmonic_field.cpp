// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/harmonic_field.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/eigen_compat.h"
#include "optimize/local_global.h"

namespace arap {

namespace {

/// Mean value of what is constrained in each part, part -1 (isolated vertices) first.
/// @param of_targets  (n_targets, 3)
std::vector<Eigen::RowVector3d> mean_values(const PreparedModel& model, const PreparedConstraints& constraints,
                                            const Positions& of_targets) {
  std::vector<Eigen::RowVector3d> sums(model.n_parts + 1, Eigen::RowVector3d::Zero());
  std::vector<int> counts(sums.size(), 0);
  for (Eigen::Index k = 0; k < of_targets.rows(); ++k) {
    const int place = model.part_of_vertex[constraints.vertex_of_target[k]] + 1;
    sums[place] += of_targets.row(k);
    ++counts[place];
  }
  for (size_t place = 0; place < sums.size(); ++place) sums[place] /= std::max(1, counts[place]);
  return sums;
}

/// What a field at the unknowns lacks at held rows: with regions, members have their unknown's value.
auto gaps_of_held(const PreparedConstraints& constraints, const Positions& targets, const Positions& field,
                  const Workers& workers) {
  const Positions of_held = constraints.held_targets(targets);
  if (constraints.regions.empty()) return constraints.held_gaps(of_held, field, workers);
  Positions of_members = field;
  constraints.regions.expand(of_members);
  return constraints.held_gaps(of_held, of_members, workers);
}

}  // namespace

HarmonicField interpolate_harmonically(const PreparedModel& model, const PreparedConstraints& constraints,
                                       const Positions& of_targets, double accuracy) {
  const ConstrainedSystem& system = constraints.system();
  const RigidRegions& regions = constraints.regions;
  // A row whose coefficients sum to s has s times the value that its unknowns should have.
  const Positions targets = constraints.target_sums.asDiagonal() * of_targets;
  Positions of_vertex = Positions::Zero(model.rest.rows(), 3);
  constraints.write_vertex_targets(targets, of_vertex);
  // From the mean of a part the way to its values is short, and none if all of them are one.
  const std::vector<Eigen::RowVector3d> means = mean_values(model, constraints, of_targets);
  Positions field = Positions::Zero(model.rest.rows(), 3);
  for (Eigen::Index v = 0; v < field.rows(); ++v)
    field.row(regions.unknown_of(static_cast<int>(v))) = means[model.part_of_vertex[v] + 1];
  for (const int v : constraints.hard_vertices) field.row(regions.unknown_of(v)) = of_vertex.row(v);
  const Positions of_anchors = constraints.anchor_targets(of_targets);
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
  system.correct_to(accuracy, residual, gaps_of_held(constraints, targets, field, model.workers));
  const double range = longest_row(residual, model.workers);
  field += residual;
  return {std::move(field), range};
}

}  // namespace arap
