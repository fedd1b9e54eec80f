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
