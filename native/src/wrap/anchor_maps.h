// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "arap/types.h"
#include "base/aligned_buffer.h"
#include "kernels/wrap_kernels.h"
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

  /// Numbers of all maps.
  [[nodiscard]] size_t n_numbers() const { return vertices_.size() * kMapNumbers; }

  /// The maps of all anchors: the rows of (D, p' - p - D p), D = B - 1, and four numbers more. A point x moves by
  /// D x + p' - p - D p.
  /// @param displacements  (n, 4) of the used vertices; the last number is 0
  void find(const WrapKernels& kernels, const AlignedBuffer<double>& displacements, const Workers& workers,
            AlignedBuffer<float>& maps) const;

 private:
  /// An anchor whose neighbours are on a line alone, along u.
  struct OnLine {
    int anchor;
    Vector3 u;
    Vector3 place;
  };
  void turn_line(const OnLine& line, const AlignedBuffer<double>& displacements, float* map) const;
  [[nodiscard]] AnchorsView view() const;

  // As AnchorsView. Two unit vectors u and v across each other span what the neighbours of an anchor tell. Both 0: they
  // do not span a plane.
  std::vector<int> vertices_;
  std::vector<int> offsets_{0};
  std::vector<int> neighbours_;
  /// D = sum of displacements, seen from the anchor, times these, within the span of u and v.
  std::vector<float> gradients_;
  std::vector<float> frames_;
  std::vector<OnLine> lines_;
};

}  // namespace arap
