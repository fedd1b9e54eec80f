// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "base/aligned_buffer.h"
#include "parallel/workers.h"
#include "wrap/surface_levels.h"
#include "wrap/used_vertices.h"

namespace arap {

/// How the surface moves around each of some nodes. In the frame in which the surface as a whole stays.
class AnchorMaps {
 public:
  struct Node {
    int level;
    int node;
  };

  AnchorMaps() = default;
  AnchorMaps(const SurfaceLevels& levels, const std::vector<Node>& anchors, int threads, UsedVertices& used);

  [[nodiscard]] int size() const { return static_cast<int>(anchors_.size()); }
  /// Numbers of a map: the rows of (D, p' - p - D p), D = B - 1. A point x moves by D x + p' - p - D p.
  static constexpr int kNumbers = 12;

  /// The maps of all anchors.
  /// @param displacements  (n, 3) of the used vertices
  void find(const Positions& displacements, const Workers& workers, AlignedBuffer<float>& maps) const;

 private:
  /// Two unit vectors across each other span what the neighbours of an anchor tell. Both 0: they tell nothing; one 0:
  /// a line alone.
  struct Anchor {
    int vertex = 0;  ///< number of a used one
    Eigen::Vector3f place;
    Eigen::Vector3f u;
    Eigen::Vector3f v;
    bool has_plane = false;  ///< neither is 0
  };
  void find_one(int anchor, const Positions& displacements, float* map) const;

  std::vector<Anchor> anchors_;
  std::vector<int> offsets_{0};  ///< of each anchor, in its neighbours
  std::vector<int> neighbours_;  ///< numbers of used vertices
  /// Of each neighbour: D = sum of displacements, seen from the anchor, times these, within the span of u and v. The
  /// last number is 0.
  std::vector<Eigen::Vector4f> gradients_;
};

}  // namespace arap
