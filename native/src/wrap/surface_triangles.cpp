// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_triangles.h"

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/nearest_in_triangle.h"
#include "mesh/surface_measures.h"
#include "mesh/triangulation.h"

namespace arap {

namespace {

std::vector<SurfaceTriangles::Corners> fans(const PolygonMesh& surface) {
  std::vector<SurfaceTriangles::Corners> triangles;
  triangles.reserve(surface.n_corners() - 2 * static_cast<size_t>(surface.n_faces()));
  for (int f = 0; f < surface.n_faces(); ++f)
    for_each_in_fan(surface.face(f), [&](int i, int j, int k) { triangles.push_back({i, j, k}); });
  return triangles;
}

}  // namespace

SurfaceTriangles::SurfaceTriangles(const PolygonMesh& surface, const SurfaceLevels& levels, const Positions& places)
    : places_(places),
      level_(levels.level(0)),
      corners_(fans(surface)),
      at_node_(level_.n_nodes(),
               [&](const auto& add) {
                 for (size_t t = 0; t < corners_.size(); ++t)
                   for (const int v : corners_[t]) add(levels.node_of_vertex()[v], static_cast<int>(t));
               }),
      areas_(Positions::Zero(level_.n_nodes(), 3)) {
  for (const Corners& corners : corners_) {
    const Vector3 a = place(corners[0]);
    const Vector3 area = (place(corners[1]) - a).cross(place(corners[2]) - a);
    volume_ += a.dot(area);
    for (const int v : corners) areas_.row(levels.node_of_vertex()[v]) += area.transpose();
  }
}

SurfaceTriangles::Places SurfaceTriangles::at(int triangle) const {
  const Corners& its = corners_[triangle];
  const Vector3 a = place(its[0]);
  return {a, place(its[1]) - a, place(its[2]) - a};
}

SurfaceTriangles::Nearest SurfaceTriangles::nearest(int node, const Vector3& place) const {
  Nearest nearest;
  look_at(node, place, nearest);
  for (const int other : level_.around(node)) look_at(other, place, nearest);
  return nearest;
}

void SurfaceTriangles::look_at(int node, const Vector3& place, Nearest& nearest) const {
  for (const int t : at_node_.of(node)) {
    const auto [a, ab, ac] = at(t);
    const Vector3 area = ab.cross(ac);
    if (!(area.norm() > kDegenerateHeight * std::pow(longest_edge(ab, ac), 2))) continue;
    const double squared = (place - nearest_in_triangle(place, a, a + ab, a + ac)).squaredNorm();
    const double above = area.dot(place - a) / area.norm();
    constexpr double kSame = 1e-6;  // not rounding decides
    const double distance = std::sqrt(squared);
    if (std::abs(distance - std::sqrt(nearest.squared)) > kSame * distance + kWrapRounding) {
      if (squared < nearest.squared) nearest = {squared, above, t};
      continue;
    }
    const double facing = std::abs(above) - std::abs(nearest.above);
    if (std::abs(facing) > kSame * distance + kWrapRounding ? facing > 0 : t < nearest.triangle)
      nearest = {squared, above, t};
  }
}

}  // namespace arap
