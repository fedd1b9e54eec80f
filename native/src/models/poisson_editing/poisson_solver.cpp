// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/poisson_editing/poisson_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/eigen_compat.h"
#include "optimize/harmonic_field.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "sparse/sparse.h"

namespace arap {

namespace {

/// Of turns, scales and positions, as a part of what they differ by.
constexpr double kAccuracy = 1e-11;

/// (n_targets, 3) logarithms of the scales in the first column; no rows where all scales are 1.
Positions log_scales_of(std::span<const Matrix3> rotations) {
  constexpr double kRounding = 1e-12;
  Positions result = Positions::Zero(rotations.size(), 3);
  for (size_t k = 0; k < rotations.size(); ++k) {
    const double log_scale = std::log(rotations[k].determinant()) / 3;
    if (std::abs(log_scale) > kRounding) result(static_cast<Eigen::Index>(k), 0) = log_scale;
  }
  return result.isZero(0) ? Positions(0, 3) : result;
}

/// What each handle constrains, by the handles of the targets' rows.
HandleVertices vertices_of(const ConstraintSet& set, const PreparedConstraints& constraints,
                           const std::vector<int>& handle_of_row, int n_handles) {
  HandleVertices vertices(n_handles);
  for (const PreparedConstraints::Entry& entry : constraints.entries)
    vertices[handle_of_row[entry.row]].push_back({entry.vertex, entry.row});
  for (int p = 0; p < set.patches.size(); ++p) {
    const int row = static_cast<int>(set.vertices.size()) + p;
    for (int k = set.patches.offsets[p]; k < set.patches.offsets[p + 1]; ++k)
      if (set.patches.weights[k] > 0) vertices[handle_of_row[row]].push_back({set.patches.vertices[k], row});
  }
  return vertices;
}

}  // namespace

void PoissonSolver::set_constraints(const ConstraintSet& set, const Progress& progress) {
  const double matrix = propagation_ == Propagation::kGeodesic ? 0.5 : 0.95;  // of the time
  auto constraints =
      std::make_unique<PreparedConstraints>(model_.prepared, ModelConstraints{set, {}}, part_of(progress, 0, matrix));
  auto handle_rotations = std::make_unique<HandleRotations>(model_.prepared, *constraints);
  Handles handles;
  handles.of_row = handle_rotations->group_of_row();
  handles.count = 1 + *std::max_element(handles.of_row.begin(), handles.of_row.end());
  for (int& handle : handles.of_row)
    if (handle < 0) handle = handles.count++;
  find_weights(set, *constraints, part_of(progress, matrix, 1), handles);
  handle_rotations_ = std::move(handle_rotations);
  constraints_ = std::move(constraints);
  handles_ = std::move(handles);
}

void PoissonSolver::find_weights(const ConstraintSet& set, const PreparedConstraints& constraints,
                                 const Progress& progress, Handles& handles) {
  // Of more handles the weights would take longer than a solve a frame does.
  constexpr int kMostHarmonic = 12;
  Meter meter(progress, "the change of constraints was cancelled");
  meter.reach(0);
  const PreparedModel& model = model_.prepared;
  if (propagation_ == Propagation::kGeodesic) {
    const int threads = model.workers.threads();
    if (graph_ == nullptr) graph_ = std::make_unique<EdgeGraph>(model.energy.K, model.rest, threads);
    const HandleVertices vertices = vertices_of(set, constraints, handles.of_row, handles.count);
    handles.weights = find_geodesic_weights(*graph_, vertices, threads, {&meter, 1});
  } else if (handles.count <= kMostHarmonic) {
    handles.weights = find_harmonic_weights(model, constraints, handles.of_row, handles.count, kAccuracy);
  }
  meter.reach(1);
}

bool PoissonSolver::are_alike(const Positions& of_rows) const {
  std::vector<int> first(handles_.count, -1);
  for (Eigen::Index k = 0; k < of_rows.rows(); ++k) {
    int& example = first[handles_.of_row[k]];
    if (example < 0) example = static_cast<int>(k);
    if (of_rows.row(k) != of_rows.row(example)) return false;
  }
  return true;
}

Positions PoissonSolver::spread(const Positions& of_rows) const {
  const bool is_by_weights =
      propagation_ == Propagation::kGeodesic || (!handles_.weights.empty() && are_alike(of_rows));
  if (is_by_weights) return handles_.weights.blend(of_rows, model_.prepared.workers);
  return interpolate_harmonically(model_.prepared, *constraints_, of_rows, kAccuracy).values;
}

Positions PoissonSolver::driven(Positions forces, const Positions& targets) const {
  const PreparedModel& model = model_.prepared;
  Positions of_vertex(model.rest.rows(), 3);  // only at constrained vertices
  constraints_->write_vertex_targets(targets, of_vertex);
  Positions positions;
  copy_rows(model.workers, model.rest, positions);
  for (const int v : constraints_->hard_vertices) {
    const Eigen::RowVector3d shift = of_vertex.row(v) - model.rest.row(v);
    for (SparseMatrix::InnerIterator it(model.energy.K, v); it; ++it) forces.row(it.row()) -= it.value() * shift;
    positions.row(v) = of_vertex.row(v);
  }
  for (const int v : constraints_->soft_vertices)
    forces.row(v) += constraints_->soft_diagonal[v] * (of_vertex.row(v) - model.rest.row(v));
  const Positions gaps = constraints_->held_gaps(constraints_->held_targets(targets), positions, model.workers);
  constraints_->system().correct_to(kAccuracy, forces, gaps);
  parallel_for<4096>(model.workers, static_cast<int>(positions.rows()), [&](int begin, int end) {
    positions.middleRows(begin, end - begin) += forces.middleRows(begin, end - begin);
  });
  return positions;
}

std::optional<PoissonSolver::Pose> PoissonSolver::solve(const Positions& targets, std::span<const Matrix3> rotations,
                                                        const Positions& last_turns, const Progress& progress) const {
  constexpr double kTurns = 0.5;  // of the time
  const auto is_stopped = [&](double fraction) { return progress && !progress(fraction); };
  if (is_stopped(0)) return std::nullopt;
  Positions last(0, 3);
  if (last_turns.rows() > 0) last = last_turns(constraints_->vertex_of_target, all);
  Pose pose;
  pose.turns = spread(handle_rotations_->from_rest(targets, rotations, last));
  const Positions of_rows = log_scales_of(rotations);
  const Positions log_scales = of_rows.rows() > 0 ? spread(of_rows) : of_rows;
  if (is_stopped(kTurns)) return std::nullopt;
  pose.positions = driven(model_.forces.find(pose.turns, log_scales, model_.prepared.workers), targets);
  if (is_stopped(1)) return std::nullopt;
  return pose;
}

}  // namespace arap
