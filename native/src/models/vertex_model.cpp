// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/vertex_model.h"

#include <cmath>
#include <utility>

#include "base/format_message.h"
#include "models/input_checks.h"

namespace arap {

VertexModel::VertexModel(const ModelSpace& space, const PreparedModel& model, int dimension)
    : space_(space),
      workers_(model.workers),
      dimension_(dimension),
      user_(space, model.part_of_vertex, model.workers),
      engine_(model) {}

VertexModel::Change VertexModel::prepare(const ConstraintSet& constraints, const Progress& progress) {
  user_.require_constraints(constraints);
  Change change;
  change.constraints = constraints;
  if (!engine_.has_constraints() || constraints != constraints_)
    change.of_engine = engine_.prepare({space_.to_model(constraints), {}}, progress);
  return change;
}

void VertexModel::take(Change change) noexcept {
  if (change.of_engine.constraints == nullptr) return;
  engine_.take(std::move(change.of_engine));
  constraints_ = std::move(change.constraints);
}

SolveResult VertexModel::solve(const Positions& targets, const SolveOptions& options,
                               std::span<const Matrix3> rotations, const Progress& progress, std::span<float> out) {
  options.validate();
  require_constrained(engine_.has_constraints());
  require_targets(constraints_, targets, rotations);
  require_out(out, user_.size());
  SolveResult result;
  result.parts_at_rest = engine_.parts_at_rest();
  result.loose_vertices = user_.loose_vertices();
  const auto hand_over = [&](const Positions& positions) { return user_.hand_over(positions, out, result); };
  IterationReport report;
  user_.guarded(out, engine_.positions(), [&] {
    report = engine_.solve(space_.targets_to_model(targets, constraints_), options, rotations, progress, hand_over);
  });
  result.energy_before = space_.energy_to_input(report.energy_before, dimension_);
  result.energy_after = space_.energy_to_input(report.energy_after, dimension_);
  result.iterations = report.iterations;
  result.step = report.step;
  result.stop_reason = report.stop_reason;
  return result;
}

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

double VertexModel::evaluate(const Positions& positions, Positions& gradient) {
  const double energy =
      space_.energy_to_input(engine_.evaluate(user_.checked_to_model(positions), gradient), dimension_);
  if (!std::isfinite(energy) || !(gradient * space_.energy_to_input(1, dimension_ - 1)).allFinite())
    throw SolverError(text("the energy at these positions is too large for a number: they are up to ",
                           space_.points_to_model(positions).cwiseAbs().maxCoeff(), " sizes of the mesh away"));
  return energy;
}

}  // namespace arap
