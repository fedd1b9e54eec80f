// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/green.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

constexpr double kPerSphere = 1 / (4 * std::numbers::pi);

/// L_e. The difference below the fraction is the ends' r_a r_b + a.b over the sum; near the edge that cancels, too.
double seen_logarithm(const CageEdge& edge, const Row& point) {
  const Row along = Row::Map(edge.along);
  const Row to_start = Row::Map(edge.start) - point;
  const Row to_end = to_start + along;
  const double product = to_start.norm() * to_end.norm();
  const double cosine = to_start.dot(to_end);
  const double apart = cosine > 0 ? product + cosine : to_start.cross(along).squaredNorm() / (product - cosine);
  const double sum = to_start.norm() + to_end.norm() + edge.length;
  return std::log(sum * sum / (2 * apart));
}

/// By the distance from its plane, and within that from the lines of its edges.
int nearest_triangle(const Cage& cage, const Row& point) {
  int nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int t = 0; t < cage.n_triangles(); ++t) {
    const TrianglePlace place(cage.triangle(t), point);
    const double outside = -*std::min_element(place.heights, place.heights + 3);
    const double distance = std::max(std::abs(place.depth), outside);
    if (distance >= least) continue;
    least = distance;
    nearest = t;
  }
  return nearest;
}

/// Solid angle of a triangle; > 0 from behind.
double solid_angle(const Cage& cage, const CageTriangle& triangle, const Row& point, double depth) {
  const Row a = cage.vertices().row(triangle.vertices[0]) - point;
  const Row b = cage.vertices().row(triangle.vertices[1]) - point;
  const Row c = cage.vertices().row(triangle.vertices[2]) - point;
  const double twice_area = (b - a).cross(c - a).norm();
  return 2 * std::atan2(depth * twice_area, a.norm() * b.norm() * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm() +
                                                a.dot(b) * c.norm());
}

}  // namespace

GreenCoordinates green_coordinates(const Cage& cage, const Row& point) {
  GreenCoordinates result;
  for (const CageTriangle& triangle : cage.triangles())
    if (TrianglePlace(triangle, point).is_on()) return result;
  result.vertices = Eigen::VectorXd::Zero(cage.n_vertices());
  result.triangles = Eigen::VectorXd::Zero(cage.n_triangles());
  std::vector<double> logarithms;
  logarithms.reserve(cage.edges().size());
  for (const CageEdge& edge : cage.edges()) logarithms.push_back(seen_logarithm(edge, point));
  for (int t = 0; t < cage.n_triangles(); ++t) {
    const CageTriangle& triangle = cage.triangle(t);
    const TrianglePlace place(triangle, point);
    const double omega = solid_angle(cage, triangle, point, place.depth);
    double of_edges[3];  // NOLINT: as in CageTriangle
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      of_edges[k] = logarithms[triangle.edges[k]];
      sum += place.heights[k] * of_edges[k];
    }
    const double factor = triangle.share * kPerSphere;
    for (int k = 0; k < 3; ++k)
      result.vertices[triangle.vertices[k]] += factor * of_corner(triangle, place, k, omega, of_edges);
    result.triangles[t] = factor * (sum - place.depth * omega);
  }
  // The sum is how often the cage winds around the point: 0 outside, a half between both cuts of a bent quad.
  constexpr double kTolerance = 1e-3;
  const double excess = result.vertices.sum() - 1;
  result.is_inside = std::abs(excess) < kTolerance;
  // Near an edge, solid angles are wrong by rounding over the distance. It is the hats of what is near that count
  // wrongly, and they all give the same place.
  const CageTriangle& nearest = cage.triangle(nearest_triangle(cage, point));
  const TrianglePlace place(nearest, point);
  for (int k = 0; k < 3; ++k) result.vertices[nearest.vertices[k]] -= excess * place.hat(k);
  return result;
}

double winding_number(const Cage& cage, const Row& point) {
  double sum = 0;
  for (const CageTriangle& triangle : cage.triangles())
    sum += triangle.share * solid_angle(cage, triangle, point, TrianglePlace(triangle, point).depth);
  return kPerSphere * sum;
}

Positions stretched_normals(const Cage& cage, const Positions& moved) {
  Positions result(cage.n_triangles(), 3);
  for (int t = 0; t < cage.n_triangles(); ++t) {
    const auto& corners = cage.triangle(t).vertices;
    const auto edge = [&](const Positions& p, int k) { return Row(p.row(corners[k]) - p.row(corners[0])); };
    const Row u = edge(cage.vertices(), 1);
    const Row v = edge(cage.vertices(), 2);
    const Row moved_u = edge(moved, 1);
    const Row moved_v = edge(moved, 2);
    const double squared = moved_u.squaredNorm() * v.squaredNorm() - 2 * moved_u.dot(moved_v) * u.dot(v) +
                           moved_v.squaredNorm() * u.squaredNorm();
    const double stretch = std::sqrt(std::max(squared, 0.0) / 2) / u.cross(v).norm();
    // A triangle without area has no normal, and then adds nothing. The area may be 1e198: its square is no number.
    result.row(t) = stretch * moved_u.cross(moved_v).stableNormalized();
  }
  return result;
}

}  // namespace arap
