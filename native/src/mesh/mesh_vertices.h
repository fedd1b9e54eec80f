// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "arap/types.h"
#include "base/union_find.h"

namespace arap {

/// Largest numbers of a mesh of any kind: sums over neighbours stay below 2^31.
inline constexpr Eigen::Index kMostVertices = 100'000'000;
inline constexpr size_t kMostCorners = 500'000'000;

/// Whether a place can be used: finite, and so near that squares of lengths do not overflow.
[[nodiscard]] inline bool is_within_range(const Eigen::RowVector3d& place) {
  constexpr double kLargest = 1e100;
  return place.allFinite() && place.cwiseAbs().maxCoeff() <= kLargest;
}

/// Throws InvalidInput if there are none, or one is not finite or beyond 1e100.
void require_rest_positions(const Positions& positions);

/// Connected parts of the vertices of a mesh, by what they are corners of: faces or tetrahedra.
struct MeshParts {
  std::vector<int> part_of_vertex;  ///< (n,) numbered by lowest vertex; -1: loose, a corner of nothing
  std::vector<int> loose_vertices;
  int n_parts = 0;
};

class MeshPartFinder {
 public:
  explicit MeshPartFinder(int n_vertices) : sets_(n_vertices), has_vertex_(n_vertices, 0) {}

  /// Corners that are of one part, in [0, n_vertices).
  void add(std::span<const int> corners);
  [[nodiscard]] MeshParts parts() &&;

 private:
  UnionFind sets_;
  std::vector<char> has_vertex_;
};

}  // namespace arap
