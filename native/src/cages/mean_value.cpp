// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/mean_value.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// An edge as a point sees it.
struct SeenEdge {
  SeenEdge(const CageEdge& edge, const Row& point) {
    const Row along = Row::Map(edge.along);
    const Row to_start = Row::Map(edge.start) - point;
    start = to_start.dot(along) / edge.length;
    end = start + edge.length;
    distance = to_start.cross(along).norm() / edge.length;
    const double cosine = to_start.dot(to_start + along);
    const double area = std::max(distance * edge.length, 1e-200);  // on the line the limit is length / cosine
    angle_over_distance = edge.length * std::atan2(area, cosine) / area;
  }

  double start;  ///< its ends on its line, from the foot of the point
  double end;
  double distance;  ///< of the line
  double angle_over_distance;
};

/// The weights of the first face that the point is on. Where it is cut in several ways, the mean of the cuts.
std::optional<Eigen::VectorXd> interpolate(const Cage& cage, const Row& point) {
  Eigen::VectorXd weights;
  int face = -1;
  int cut = -1;
  for (int t = 0; t < cage.n_triangles(); ++t) {
    if (face >= 0 && cage.face_of_triangle()[t] != face) break;
    const TrianglePlace place(cage.triangle(t), point);
    if (cage.cut_of_triangle()[t] == cut || !place.is_on()) continue;
    if (face < 0) weights = Eigen::VectorXd::Zero(cage.n_vertices());
    face = cage.face_of_triangle()[t];
    cut = cage.cut_of_triangle()[t];
    for (int k = 0; k < 3; ++k) weights[cage.triangle(t).vertices[k]] += cage.triangle(t).share * place.hat(k);
  }
  if (face < 0) return std::nullopt;
  return weights / weights.sum();
}

/// S / d where the foot of the point is outside of the triangle. There sum sign(h_e) phi_e = 0, phi the angles that the
/// foot sees the edges at. What is left of theta - phi and of |h| / s - 1 is of the order of d^2.
double area_over_depth_outside(const TrianglePlace& place, const std::array<const SeenEdge*, 3>& edges) {
  const double d = place.depth;
  double of_angles = 0;
  double of_distances = 0;
  for (int k = 0; k < 3; ++k) {
    const double side = place.heights[k] < 0 ? -1 : 1;
    const double h = std::abs(place.heights[k]);
    const double s = std::hypot(h, d);
    const auto lost = [&](double along) {
      return along == 0 ? 0 : std::atan(along * d * d / ((s + h) * (h * s + along * along)));
    };
    of_angles += side * (lost(edges[k]->end) - lost(edges[k]->start));
    of_distances += side * edges[k]->angle_over_distance / (s + h);
  }
  return -of_angles / d - d * of_distances;
}

double area_over_depth(const TrianglePlace& place, const std::array<const SeenEdge*, 3>& edges) {
  // About how far outside the foot is. Beside the weights of what is so near, rounding is there 1e-16 outside / d in
  // the sum, and 1e-16 d / outside^2 in the other form.
  const double outside = -*std::min_element(place.heights, place.heights + 3);
  if (outside > 0 && place.depth * place.depth < outside * outside * outside)
    return area_over_depth_outside(place, edges);
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += place.heights[k] * edges[k]->angle_over_distance;
  return sum / place.depth;
}

/// A place in a triangle, as barycentric coordinates, and its part of an integral over it: Radon's rule of degree 5.
struct Place {
  double hats[3];  // NOLINT: as in CageTriangle
  double part;
};
std::array<Place, 7> places_in_triangle() {
  std::array<Place, 7> places{};
  places[0] = {{1. / 3, 1. / 3, 1. / 3}, .225};
  for (const int side : {-1, 1}) {
    const double root = side * std::sqrt(15.);
    const double hat = (6 + root) / 21;
    for (int k = 0; k < 3; ++k) {
      Place& place = places[1 + k + (side < 0 ? 0 : 3)];
      for (int i = 0; i < 3; ++i) place.hats[i] = i == k ? 1 - 2 * hat : hat;
      place.part = (155 + root) / 1200;
    }
  }
  return places;
}

/// Far away the closed form cancels: wrong by 1e-16 times the third power of the distance. But there what is integrated
/// hardly changes over a triangle, so a rule will do. The sum of the weights cancels once more, and is taken from
/// inside: the integral over the cage's volume of -1 / |y - x|^4, the divergence, as all triangles seen from the
/// middle.
Eigen::VectorXd far_weights(const Cage& cage, const Row& point) {
  const std::array<Place, 7> places = places_in_triangle();
  const double root = std::sqrt(.15);  // three places along a radius: Gauss' rule of degree 5
  const std::array<std::pair<double, double>, 3> radii = {{{.5 - root, 5. / 18}, {.5, 8. / 18}, {.5 + root, 5. / 18}}};
  const double unit = point.squaredNorm();  // so that no power of a distance leaves the range of numbers
  const auto kernel = [&](const Row& y) { return std::pow(unit / (y - point).squaredNorm(), 2); };
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(cage.n_vertices());
  double sum = 0;
  for (const CageTriangle& triangle : cage.triangles()) {
    const double depth = TrianglePlace(triangle, point).depth;
    for (const Place& place : places) {
      Row y = Row::Zero();
      for (int k = 0; k < 3; ++k) y += place.hats[k] * cage.vertices().row(triangle.vertices[k]);
      const double area = triangle.share * place.part * triangle.twice_area / 2;
      for (int k = 0; k < 3; ++k) weights[triangle.vertices[k]] += area * depth * place.hats[k] * kernel(y);
      for (const auto& [radius, part] : radii)
        sum -= area * triangle.depth[3] * part * radius * radius * kernel(radius * y);
    }
  }
  return weights / sum;
}

}  // namespace

Eigen::VectorXd mean_value_coordinates(const Cage& cage, const Row& point) {
  if (point.squaredNorm() > kFarFromCage * kFarFromCage) return far_weights(cage, point);
  if (const auto on_face = interpolate(cage, point)) return *on_face;
  std::vector<SeenEdge> edges;
  edges.reserve(cage.edges().size());
  for (const CageEdge& edge : cage.edges()) edges.emplace_back(edge, point);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(cage.n_vertices());
  for (const CageTriangle& triangle : cage.triangles()) {
    const TrianglePlace place(triangle, point);
    if (place.depth == 0) continue;  // in its plane and outside of it
    const std::array<const SeenEdge*, 3> own{&edges[triangle.edges[0]], &edges[triangle.edges[1]],
                                             &edges[triangle.edges[2]]};
    const double angles[3] = {own[0]->angle_over_distance, own[1]->angle_over_distance, own[2]->angle_over_distance};
    const double over_depth = area_over_depth(place, own);
    for (int k = 0; k < 3; ++k)
      weights[triangle.vertices[k]] += triangle.share * of_corner(triangle, place, k, over_depth, angles);
  }
  return weights / weights.sum();
}

}  // namespace arap
