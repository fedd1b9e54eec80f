// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"
#include "wrap/surface_levels.h"
#include "wrap/used_vertices.h"

namespace arap {

/// Keeps points on the side of the surface where they were at rest, at no less than their distance from it. Each has
/// the plane of the triangle nearest to it; this moves with the surface. So it does not matter which way faces are
/// turned. What is very near to the surface keeps its distance exactly: a point on it stays on it. Only points that are
/// near, measured by the triangle's size, are pushed: farther away the surface bends less between its vertices than the
/// point is away.
class SurfaceSides {
 public:
  SurfaceSides() = default;
  /// @param places   (n_vertices, 3) of the surface, in the space of the points
  /// @param nearest  of each point the nearest node of the first level
  SurfaceSides(const PolygonMesh& surface, const SurfaceLevels& levels, const Positions& places,
               const Positions& points, const std::vector<int>& nearest, int threads, UsedVertices& used);

  /// Where point p may be instead of `place`.
  /// @param rest_unit  of lengths at rest, in the space of the places
  /// @param moved      moved(k): place of the vertex with this number of `used`
  template <class Moved>
  [[nodiscard]] Vector3 keep(int p, const Vector3& place, double rest_unit, const Moved& moved) const {
    if (sides_.empty() || sides_[p].corners[0] < 0) return place;
    const Side& side = sides_[p];
    const Vector3 a = moved(side.corners[0]);
    const Vector3 b = moved(side.corners[1]);
    const Vector3 c = moved(side.corners[2]);
    return pushed(side, rest_unit, place, a, b - a, c - a);
  }

 private:
  struct Side {
    std::array<int, 3> corners{-1, -1, -1};
    float strength = 0;   ///< of the push away from the triangle: from 1 near to it to 0
    float pull = 0;       ///< of the pull towards it: from 1 on it to 0
    double distance = 0;  ///< from the plane at rest; < 0: behind the triangle
    /// Of the matrix G of products of ab and ac at rest, from the first corner: entries 00, 01 and 11 of the inverse.
    std::array<double, 3> inverse{};
  };

  [[nodiscard]] static double length_of(const Side& side, const Vector3& ab, const Vector3& ac, double rest_unit);
  [[nodiscard]] static Vector3 pushed(const Side& side, double rest_unit, const Vector3& place, const Vector3& a,
                                      const Vector3& ab, const Vector3& ac);

  std::vector<Side> sides_;
};

}  // namespace arap
