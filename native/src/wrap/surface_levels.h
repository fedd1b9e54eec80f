// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"
#include "parallel/meter.h"

namespace arap {

/// Vertices of a surface that are about equally far apart, and which of them are neighbours along the surface.
struct SurfaceLevel {
  std::vector<int> vertices;  ///< of the surface, of each node
  Positions places;           ///< (n_nodes, 3)
  std::vector<int> offsets;   ///< of each node, in `neighbours`
  std::vector<int> neighbours;
  std::vector<int> coarser;  ///< of each node: which one of the next level stands for it; empty in the last level

  [[nodiscard]] int n_nodes() const { return static_cast<int>(vertices.size()); }
  [[nodiscard]] std::span<const int> around(int node) const {
    return std::span(neighbours).subspan(offsets[node], offsets[node + 1] - offsets[node]);
  }
};

/// All vertices of a surface in faces, one of each place, and ever fewer of them: each level twice as far apart as the
/// one before. Small parts of the surface keep what they have. Without faces, near points are neighbours.
class SurfaceLevels {
 public:
  /// @param places  (n_vertices, 3) of the surface, to work in
  SurfaceLevels(const PolygonMesh& surface, const Positions& places, int threads, const MeterPart& meter = {});

  [[nodiscard]] int size() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const SurfaceLevel& level(int k) const { return levels_[k]; }
  /// Of each vertex of the surface: its node of the first level; -1 for loose vertices.
  [[nodiscard]] const std::vector<int>& node_of_vertex() const { return node_of_vertex_; }
  /// Mean distance of neighbours in the first level; > 0.
  [[nodiscard]] double spacing() const { return spacing_; }

 private:
  std::vector<SurfaceLevel> levels_;
  std::vector<int> node_of_vertex_;
  double spacing_ = 1;
};

}  // namespace arap
