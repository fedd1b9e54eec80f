// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/vertex_model.h"

#include <cmath>
#include <utility>

#include "base/format_message.h"
#include "models/input_checks.h"

namespace arap {

VertexModel::VertexModel(const ModelSpace& space, const PreparedModel& model, int dimension)
    : space_(space), workers_(model.workers), dimension_(dimension), engine_(model) {
  part_of_vertex_.reserve(space.model_vertices().size());
  for (const int m : space.model_vertices()) {
    if (model.part_of_vertex[m] < 0) loose_vertices_.push_back(static_cast<int>(part_of_vertex_.size()));
    part_of_vertex_.push_back(model.part_of_vertex[m]);
  }
}

void VertexModel::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  constraints.validate(space_.n_input_vertices());
  require_no_segments(constraints);
  require_movable_patches(constraints.patches, part_of_vertex_);
  if (engine_.has_constraints() && constraints == constraints_) return;
  ConstraintSet copy = constraints;
  engine_.set_constraints({space_.to_model(constraints), {}}, progress);
  constraints_ = std::move(copy);
}

SolveResult VertexModel::solve(const Positions& targets, const SolveOptions& options,
                               std::span<const Matrix3> rotations, const Progress& progress, std::span<float> out) {
  options.validate();
  require_constrained(engine_.has_constraints());
  require_targets(constraints_, targets, rotations);
  require_out(out, space_.n_input_vertices());
  SolveResult result;
  const auto hand_over = [&](const Positions& positions) {
    if (!out.empty()) return space_.write_to_input(positions, workers_, out);
    result.positions = space_.to_input(positions, workers_);
    return all_finite(result.positions, workers_);
  };
  IterationReport report;
  try {
    report = engine_.solve(space_.targets_to_model(targets, constraints_), options, rotations, progress, hand_over);
  } catch (...) {
    if (!out.empty()) static_cast<void>(space_.write_to_input(engine_.positions(), workers_, out));
    throw;
  }
  result.energy_before = space_.energy_to_input(report.energy_before, dimension_);
  result.energy_after = space_.energy_to_input(report.energy_after, dimension_);
  result.iterations = report.iterations;
  result.step = report.step;
  result.stop_reason = report.stop_reason;
  result.parts_at_rest = engine_.parts_at_rest();
  result.loose_vertices = loose_vertices_;
  return result;
}

void VertexModel::set_positions(const Positions& positions) { engine_.set_positions(checked_to_model(positions)); }

Positions VertexModel::positions() const { return space_.to_input(engine_.positions(), workers_); }

double VertexModel::energy(const Positions& positions) {
  Positions gradient;
  return evaluate(positions, gradient);
}

Positions VertexModel::energy_gradient(const Positions& positions) {
  Positions gradient;
  evaluate(positions, gradient);
  return space_.gradient_to_input(gradient, dimension_);
}

Positions VertexModel::checked_to_model(const Positions& positions) const {
  require_rows("positions", positions.rows(), space_.n_input_vertices());
  require_finite("positions", positions, [](int v) { return text("vertex ", v); });
  return space_.to_model(positions, workers_);
}

double VertexModel::evaluate(const Positions& positions, Positions& gradient) {
  const double energy = space_.energy_to_input(engine_.evaluate(checked_to_model(positions), gradient), dimension_);
  if (!std::isfinite(energy) || !(gradient * space_.energy_to_input(1, dimension_ - 1)).allFinite())
    throw SolverError(text("the energy at these positions is too large for a number: they are up to ",
                           space_.points_to_model(positions).cwiseAbs().maxCoeff(), " sizes of the mesh away"));
  return energy;
}

}  // namespace arap
