// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"

namespace arap {

/// A weighted average of vertices.
struct Patch {
  std::vector<int> vertices;
  std::vector<double> weights;              ///< sum 1
  Vector3 rest_position = Vector3::Zero();  ///< the average at rest: the target that moves nothing
};

/// Weighted averages of vertices that are constrained as one point each. Patch k consists of the entries
/// offsets[k] .. offsets[k + 1] - 1 of `vertices` and `weights`. Weights are >= 0 and are scaled to sum 1.
/// There may be as many of up to 64 vertices as one likes. Some hundreds that are wider, or partly in a rigid region,
/// take a small part of a solve's time and memory each; the time of some thousands grows with their cube.
struct Patches {
  std::vector<int> offsets;  ///< n_patches + 1 entries, or empty: no patches
  std::vector<int> vertices;
  std::vector<double> weights;

  void add(const Patch& patch);
  [[nodiscard]] int size() const { return offsets.empty() ? 0 : static_cast<int>(offsets.size()) - 1; }
  bool operator==(const Patches&) const = default;
};

/// A bone: a straight line through the inside of a mesh, from head to tail at rest, in the mesh's space. What is around
/// it moves as one body, but for some of it at each end, where bones meet: as long as it is from there to the surface.
///
/// It has four targets, which say where it goes and how it turns: of its head, and of head + l x, head + l y and
/// head + l z, with l = |tail - head| and x, y, z the axes of the mesh's space.
struct Segment {
  Vector3 head;
  Vector3 tail;

  static constexpr int kTargets = 4;
  /// The four places at rest, row by row: the targets that move nothing.
  [[nodiscard]] Positions rest_targets() const;
  bool operator==(const Segment&) const = default;
};

/// The set of constraints: which vertices (each at most once), how strongly, which averages and which bones. Targets
/// are not part of it: they come with every solve, one row per entry of `vertices`, then one per patch, then four per
/// segment.
struct ConstraintSet {
  std::vector<int> vertices;
  /// Of each vertex, in (0, 1]; empty: all hard. 1 is hard. s < 1 is soft: it adds omega_i |p'_i - target|^2 to the
  /// energy 1/2 <p', K p'> + ..., with omega_i = K_ii s / (1 - s). At 1/3 the target pulls at a vertex as strongly as
  /// its neighbours do. The models with an omega of their own, whose unknowns are no vertices, say it at
  /// set_constraints(): LatticeArap, EmbeddedDeformation, CageArap. A part of the mesh that nothing holds more strongly
  /// than 1e-9 is refused.
  std::vector<double> strengths;
  /// Held exactly. If more than half of a patch's weight lies in one rigid region, the whole patch is attached to it.
  Patches patches;
  /// Only models with an inside take them: LatticeArap.
  std::vector<Segment> segments{};  // NOLINT(readability-redundant-member-init): so that a braced list may leave it out

  /// Rows of targets.
  [[nodiscard]] int n_targets() const {
    return static_cast<int>(vertices.size()) + patches.size() + Segment::kTargets * static_cast<int>(segments.size());
  }
  bool operator==(const ConstraintSet&) const = default;

  /// Throws InvalidInput naming the entry: index out of [0, n_vertices), twice the same vertex, strength out of (0, 1],
  /// lengths that do not fit, a patch without weight, a segment that is not finite or has no length, or nothing
  /// constrained at all.
  void validate(int n_vertices) const;
};

}  // namespace arap
