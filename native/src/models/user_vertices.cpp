// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/user_vertices.h"

#include "base/format_message.h"
#include "models/input_checks.h"

namespace arap {

UserVertices::UserVertices(const ModelSpace& space, const std::vector<int>& part_of_vertex, const Workers& workers)
    : space_(space), workers_(workers) {
  part_of_vertex_.reserve(space.model_vertices().size());
  for (const int m : space.model_vertices()) {
    if (part_of_vertex[m] < 0) loose_vertices_.push_back(static_cast<int>(part_of_vertex_.size()));
    part_of_vertex_.push_back(part_of_vertex[m]);
  }
}

void UserVertices::require_constraints(const ConstraintSet& constraints) const {
  constraints.validate(size());
  require_no_segments(constraints);
  require_movable_patches(constraints.patches, part_of_vertex_);
  require_strength(constraints, part_of_vertex_);
}

Positions UserVertices::checked_to_model(const Positions& positions) const {
  require_rows("positions", positions.rows(), size());
  require_finite("positions", positions, [](int v) { return text("vertex ", v); });
  return space_.to_model(positions, workers_);
}

bool UserVertices::hand_over(const Positions& of_model, std::span<float> out, SolveResult& result) const {
  if (!out.empty()) return space_.write_to_input(of_model, workers_, out);
  result.positions = space_.to_input(of_model, workers_);
  return all_finite(result.positions, workers_);
}

}  // namespace arap
