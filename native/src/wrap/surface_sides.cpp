// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_sides.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/grouped.h"
#include "geometry/nearest_in_triangle.h"
#include "mesh/surface_measures.h"
#include "mesh/triangulation.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

using Corners = std::array<int, 3>;

/// Beyond so many of the triangle's longest edges a point is not pushed any more; from half of it on less and less.
constexpr double kFarthest = 4;
/// Nearer than so many of them it is also pulled, more and more: what is tight keeps its distance, and nothing jumps
/// where it changes sides.
constexpr double kNearest = 1;
/// A point beside the triangle, as beyond the rim of an open surface, is on no side of it: the least distance from the
/// plane, of that from the triangle.
constexpr double kLeastAbove = .5;

double longest_edge(const Vector3& ab, const Vector3& ac) { return std::max({ab.norm(), ac.norm(), (ac - ab).norm()}); }

/// The fans from the first corners.
std::vector<Corners> fans(const PolygonMesh& surface) {
  std::vector<Corners> triangles;
  for (int f = 0; f < surface.n_faces(); ++f)
    for_each_in_fan(surface.face(f), [&](int i, int j, int k) { triangles.push_back({i, j, k}); });
  return triangles;
}

class Triangles {
 public:
  Triangles(const PolygonMesh& surface, const SurfaceLevels& levels, const Positions& places)
      : places_(places),
        level_(levels.level(0)),
        corners_(fans(surface)),
        at_node_(level_.n_nodes(), [&](const auto& add) {
          for (size_t t = 0; t < corners_.size(); ++t)
            for (const int v : corners_[t]) add(levels.node_of_vertex()[v], static_cast<int>(t));
        }) {}

  struct Nearest {
    double squared = std::numeric_limits<double>::infinity();  ///< distance
    double above = 0;                                          ///< distance from its plane, < 0 behind it
    int triangle = -1;
  };

  [[nodiscard]] const Corners& corners(int triangle) const { return corners_[triangle]; }
  [[nodiscard]] Vector3 place(int vertex) const { return places_.row(vertex).transpose(); }

  /// Of those at a node and at its neighbours.
  [[nodiscard]] Nearest nearest(int node, const Vector3& place) const {
    Nearest nearest;
    look_at(node, place, nearest);
    for (const int other : level_.around(node)) look_at(other, place, nearest);
    return nearest;
  }

 private:
  /// Replaces `nearest` by a triangle at the node that is nearer to `place`, and is not degenerate. Of those that share
  /// the nearest edge or corner it is the one that faces the place.
  void look_at(int node, const Vector3& place, Nearest& nearest) const {
    for (const int t : at_node_.of(node)) {
      const Vector3 a = this->place(corners_[t][0]);
      const Vector3 b = this->place(corners_[t][1]);
      const Vector3 c = this->place(corners_[t][2]);
      const Vector3 area = (b - a).cross(c - a);
      if (!(area.norm() > kDegenerateHeight * std::pow(longest_edge(b - a, c - a), 2))) continue;
      const double squared = (place - nearest_in_triangle(place, a, b, c)).squaredNorm();
      const double above = area.dot(place - a) / area.norm();
      constexpr double kSame = 1e-9;
      const bool is_tie = std::abs(squared - nearest.squared) <= kSame * squared;
      if (is_tie ? std::abs(above) > std::abs(nearest.above) : squared < nearest.squared) nearest = {squared, above, t};
    }
  }

  const Positions& places_;
  const SurfaceLevel& level_;
  std::vector<Corners> corners_;
  Grouped at_node_;
};

}  // namespace

SurfaceSides::SurfaceSides(const PolygonMesh& surface, const SurfaceLevels& levels, const Positions& places,
                           const Positions& points, const std::vector<int>& nearest_node, int threads,
                           UsedVertices& used) {
  if (surface.n_faces() == 0) return;
  const Triangles triangles(surface, levels, places);
  sides_.resize(points.rows());
  parallel_for(threads, static_cast<int>(points.rows()), [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      const Vector3 place = points.row(p).transpose();
      const Triangles::Nearest nearest = triangles.nearest(nearest_node[p], place);
      if (nearest.triangle < 0) continue;
      const Corners& corners = triangles.corners(nearest.triangle);
      const Vector3 a = triangles.place(corners[0]);
      const Vector3 ab = triangles.place(corners[1]) - a;
      const Vector3 ac = triangles.place(corners[2]) - a;
      const double above = nearest.above;
      const double away = std::sqrt(nearest.squared);
      const double longest = longest_edge(ab, ac);
      const double strength = std::clamp(2 - 2 * away / (kFarthest * longest), 0., 1.);
      if (!(strength > 0) || !(std::abs(above) >= kLeastAbove * away)) continue;
      const double pull = std::max(1 - away / (kNearest * longest), 0.);
      const double products = ab.dot(ac);
      const double determinant = ab.cross(ac).squaredNorm();
      sides_[p] = {corners,
                   static_cast<float>(strength),
                   static_cast<float>(pull),
                   above,
                   {ac.squaredNorm() / determinant, -products / determinant, ab.squaredNorm() / determinant}};
    }
  });
  for (Side& side : sides_)
    if (side.corners[0] >= 0)
      for (int& corner : side.corners) corner = used.number_of(corner);
}

/// Of lengths at rest, if the triangle is larger or smaller in every direction: of its stretches the one nearest to
/// rest_unit, or that between them. So one that only bends or folds is as large as before.
double SurfaceSides::length_of(const Side& side, const Vector3& ab, const Vector3& ac, double rest_unit) {
  const auto [i00, i01, i11] = side.inverse;
  const double g00 = ab.squaredNorm();
  const double g01 = ab.dot(ac);
  const double g11 = ac.squaredNorm();
  // Squared stretches are the eigenvalues of M = G^-1 times G now.
  const double m00 = i00 * g00 + i01 * g01;
  const double m01 = i00 * g01 + i01 * g11;
  const double m10 = i01 * g00 + i11 * g01;
  const double m11 = i01 * g01 + i11 * g11;
  const double mean = (m00 + m11) / 2;
  const double half = std::sqrt(std::max(0., (m00 - m11) * (m00 - m11) / 4 + m01 * m10));
  return std::sqrt(std::max(mean - half, std::min(rest_unit * rest_unit, mean + half)));
}

Vector3 SurfaceSides::pushed(const Side& side, double rest_unit, const Vector3& place, const Vector3& a,
                             const Vector3& ab, const Vector3& ac) {
  const Vector3 area = ab.cross(ac);
  const double squared_size = area.squaredNorm();
  if (!(squared_size > 0)) return place;
  const double sign = side.distance < 0 ? -1 : 1;
  const double wanted = length_of(side, ab, ac, rest_unit) * side.distance;
  const double missing = sign * (wanted * std::sqrt(squared_size) - area.dot(place - a));  // times the size of the area
  const auto share = static_cast<double>(missing > 0 ? side.strength : side.pull);
  if (share == 0) return place;
  return place + sign * share * missing / squared_size * area;
}

}  // namespace arap
