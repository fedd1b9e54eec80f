// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"
#include "base/grouped.h"
#include "wrap/surface_levels.h"

namespace arap {

/// What rounding leaves of a distance 0 on a surface of diagonal 1, a million diagonals from the origin.
inline constexpr double kWrapRounding = 1e-8;

/// Of the edges ab, ac and bc of a triangle.
[[nodiscard]] inline double longest_edge(const Vector3& ab, const Vector3& ac) {
  return std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
}

/// The triangles of a surface, the fans from the first corners of its faces, and which of them is nearest to a point.
class SurfaceTriangles {
 public:
  using Corners = std::array<int, 3>;  ///< vertices of the surface

  /// @param levels  of the surface; kept by reference, as `places` are
  /// @param places  (n_vertices, 3) of the surface, in the space of the levels
  SurfaceTriangles(const PolygonMesh& surface, const SurfaceLevels& levels, const Positions& places);

  struct Nearest {
    double squared = std::numeric_limits<double>::infinity();  ///< distance
    double above = 0;                                          ///< distance from its plane, < 0 behind it
    int triangle = -1;
  };

  /// The first corner, and the edges from there.
  struct Places {
    Vector3 a;
    Vector3 ab;
    Vector3 ac;
  };

  [[nodiscard]] bool is_empty() const { return corners_.empty(); }
  [[nodiscard]] const Corners& corners(int triangle) const { return corners_[triangle]; }
  [[nodiscard]] Places at(int triangle) const;

  /// Whether a place is inside as seen from the node of the first level that is nearest to it: behind the triangles
  /// there, whichever way most of the surface faces. Of a sheet either side may be.
  [[nodiscard]] bool is_behind(int node, const Vector3& place) const {
    return areas_.row(node).dot(place.transpose() - level_.places.row(node)) * volume_ < 0;
  }

  /// Of those at a node of the first level and at its neighbours.
  [[nodiscard]] Nearest nearest(int node, const Vector3& place) const;

 private:
  [[nodiscard]] Vector3 place(int vertex) const { return places_.row(vertex).transpose(); }
  /// Replaces `nearest` by a triangle at the node that is nearer to `place`, and is not degenerate. Of those that share
  /// the nearest edge or corner it is the one that faces the place, and of those in one plane the first.
  void look_at(int node, const Vector3& place, Nearest& nearest) const;

  const Positions& places_;
  const SurfaceLevel& level_;  ///< the first
  std::vector<Corners> corners_;
  Grouped at_node_;
  Positions areas_;    ///< twice the vector areas of the triangles at each node
  double volume_ = 0;  ///< six times what the surface encloses; < 0: its faces are turned inwards
};

}  // namespace arap
