// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "arap/types.h"
#include "base/aligned_buffer.h"
#include "kernels/wrap_kernels.h"
#include "wrap/surface_triangles.h"
#include "wrap/used_vertices.h"

namespace arap {

/// Keeps points on the side of the surface where they were at rest, at their distance from it. Each has the plane of
/// the triangle nearest to it; this moves with the surface. So it does not matter which way faces are turned. Only
/// points that are near, measured by the triangle's size, are held so: farther away the surface bends less between its
/// vertices than the point is away. Nor are those that hang on walls on all sides. Distances grow with most of the
/// surface, and if a triangle is far larger or smaller than that.
class SurfaceSides {
 public:
  SurfaceSides() = default;
  /// @param points   (n, 3) in the space of the triangles
  /// @param nearest  of each point the nearest node of the first level
  /// @param around   of each point how much it hangs on walls on all sides, 0 to 1
  SurfaceSides(const SurfaceTriangles& triangles, const Positions& points, const std::vector<int>& nearest,
               const std::vector<double>& around, int threads, UsedVertices& used);

  /// How many times as long as at rest the lengths along the triangles are, by most of them that agree: a body that
  /// only bends is as large as before, whatever similarity fits it best.
  /// @param displacements  (n, 4) of the used vertices, the last number 0
  [[nodiscard]] double growth(const AlignedBuffer<double>& displacements) const;

  /// Adds what keeps them on their sides to the moves of the points [begin, end), see WrapKernels.
  void push(const WrapKernels& kernels, const AlignedBuffer<double>& displacements, double growth, float* moves,
            int begin, int end) const {
    if (!corners_.empty())
      kernels.push_points({corners_.data(), numbers_.data()}, displacements.data(), static_cast<float>(growth), moves,
                          begin, end);
  }

 private:
  /// Of some points.
  struct Triangle {
    std::array<int, 3> corners;
    Vector3 ab;
    Vector3 ac;
  };

  // As SidesView.
  std::vector<int> corners_;
  std::vector<float> numbers_;
  std::vector<Triangle> samples_;
};

}  // namespace arap
