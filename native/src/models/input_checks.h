// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/error.h"
#include "arap/mesh.h"
#include "arap/types.h"
#include "base/format_message.h"
#include "mesh/mesh_vertices.h"
#include "parallel/workers.h"

namespace arap {

/// What every face checks before it hands something to the engine. All throw InvalidInput.

void require_rows(const char* what, Eigen::Index rows, Eigen::Index expected);

/// Finite and below 1e100.
/// @param name  name(row) for the message
template <class Name>
void require_finite(const char* what, const Positions& positions, const Name& name) {
  for (Eigen::Index k = 0; k < positions.rows(); ++k)
    if (!is_within_range(positions.row(k)))
      throw InvalidInput(text(what, ": ", name(static_cast<int>(k)), " is (", positions(k, 0), ", ", positions(k, 1),
                              ", ", positions(k, 2), "), must be finite and below 1e100"));
}

/// No patch may contain an isolated vertex, which nothing could move.
/// @param part_of_vertex  (n,) -1 = isolated
void require_movable_patches(const Patches& patches, const std::vector<int>& part_of_vertex);

/// A part that only soft constraints hold needs one that rounding does not drown. Bones may hold any.
/// @param part_of_vertex  as above
void require_strength(const ConstraintSet& set, const std::vector<int>& part_of_vertex);

/// For models without an inside.
void require_no_segments(const ConstraintSet& set);

/// Targets of a set, and rotations of each or none.
void require_targets(const ConstraintSet& set, const Positions& targets, std::span<const Matrix3> rotations);

/// Room for the positions in single precision, or none.
void require_out(std::span<const float> out, int n_vertices);

/// A solve needs a set of constraints.
void require_constrained(bool has_constraints);

[[nodiscard]] bool all_finite(const Positions& x, const Workers& workers);

}  // namespace arap
