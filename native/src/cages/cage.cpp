// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "arap/error.h"
#include "cages/cage_checks.h"
#include "mesh/surface_measures.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;
using Corners = std::array<int, 3>;

/// A lower triangle is left out: its hats lose as many digits as it is low, and what it adds is as small.
constexpr double kLeastHeight = 1e-8;

/// The two triangles of a quad on both sides of the diagonal from corner `from`.
std::array<Corners, 2> halves(std::span<const int> face, int from) {
  const auto corner = [&](int k) { return face[(from + k) % 4]; };
  return {{{corner(0), corner(1), corner(2)}, {corner(0), corner(2), corner(3)}}};
}

/// Whether the triangles are on the side of the face, so that the diagonal is inside of it.
bool is_inside(const Positions& p, const std::array<Corners, 2>& triangles, const Row& of_face) {
  return std::all_of(triangles.begin(), triangles.end(),
                     [&](const Corners& corners) { return twice_vector_area(p, corners).dot(of_face) > 0; });
}

void set_linear(double* function, const Row& gradient, const Row& zero) {
  Row::Map(function) = gradient;
  function[3] = -gradient.dot(zero);
}

}  // namespace

class Cage::Builder {
 public:
  explicit Builder(Cage& cage) : cage_(cage) {}

  void add_face(std::span<const int> face, int number) {
    const Positions& p = cage_.vertices_;
    face_ = number;
    plane_.reset();
    if (face.size() == 3) {
      add_cut(std::array<Corners, 1>{{{face[0], face[1], face[2]}}}, 1);
      return;
    }
    const Row of_face = twice_vector_area(p, face);
    find_plane(face, of_face);
    const std::array<Corners, 2> first = halves(face, 0);
    const std::array<Corners, 2> second = halves(face, 1);
    const bool has_first = is_inside(p, first, of_face);
    const bool has_second = is_inside(p, second, of_face);
    const double share = has_first == has_second ? .5 : 1;
    if (has_first || !has_second) add_cut(first, share);
    if (has_second || !has_first) add_cut(second, share);
  }

 private:
  struct Plane {
    Row normal;
    Row place;
  };

  /// The triangles of a flat quad have one plane to the last bit. Near it, how much each cut counts is the ratio of the
  /// distances to their planes, and with rounding in it, it would be random.
  void find_plane(std::span<const int> face, const Row& of_face) {
    constexpr double kFlat = 1e-13;
    if (!(of_face.norm() > kFlat)) return;  // of a quad whose halves are opposite there is none
    const Positions& p = cage_.vertices_;
    const Row normal = of_face.normalized();
    const Row middle = (p.row(face[0]) + p.row(face[1]) + p.row(face[2]) + p.row(face[3])) / 4;
    if (std::all_of(face.begin(), face.end(), [&](int v) { return std::abs(normal.dot(p.row(v) - middle)) < kFlat; }))
      plane_ = Plane{normal, middle};
  }

  void add_cut(std::span<const Corners> triangles, double share) {
    for (const Corners& corners : triangles) add_triangle(corners, share);
    ++n_cuts_;
  }

  void add_triangle(const Corners& corners, double share) {
    const Positions& p = cage_.vertices_;
    const Row twice_area = twice_vector_area(p, corners);
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (p.row(corners[k]) - p.row(corners[(k + 1) % 3])).norm());
    if (!(twice_area.norm() > kLeastHeight * longest)) return;
    Plane plane = plane_.value_or(Plane{twice_area.normalized(), p.row(corners[0])});
    if (plane.normal.dot(twice_area) < 0) plane.normal = -plane.normal;  // of a face that crosses itself
    CageTriangle triangle{};
    triangle.share = share;
    triangle.twice_area = twice_area.norm();
    set_linear(triangle.depth, -plane.normal, plane.place);
    std::array<Row, 3> outwards;
    for (int k = 0; k < 3; ++k) {
      const int from = corners[(k + 1) % 3];
      const int to = corners[(k + 2) % 3];
      // From the lower vertex to the higher one: triangles of one plane have the same line, turned, to the last bit.
      const Row along = p.row(std::max(from, to)) - p.row(std::min(from, to));
      outwards[k] = (from < to ? 1 : -1) * along.cross(plane.normal).normalized();
      triangle.vertices[k] = corners[k];
      triangle.edges[k] = edge(from, to);
      triangle.per_height[k] = along.norm() / twice_area.norm();
      set_linear(triangle.heights[k], -outwards[k], p.row(std::min(from, to)));
    }
    for (int k = 0; k < 3; ++k) triangle.cosines[k] = outwards[(k + 1) % 3].dot(outwards[(k + 2) % 3]);
    cage_.triangles_.push_back(triangle);
    cage_.cut_of_triangle_.push_back(n_cuts_);
    cage_.face_of_triangle_.push_back(face_);
  }

  int edge(int from, int to) {
    const auto [place, is_new] = edges_.try_emplace(std::minmax(from, to), static_cast<int>(cage_.edges_.size()));
    if (is_new) {
      const Row along = cage_.vertices_.row(to) - cage_.vertices_.row(from);
      CageEdge edge{};
      Row::Map(edge.start) = cage_.vertices_.row(from);
      Row::Map(edge.along) = along;
      edge.length = along.norm();
      edge.ends[0] = from;
      edge.ends[1] = to;
      cage_.edges_.push_back(edge);
    }
    return place->second;
  }

  Cage& cage_;
  std::map<std::pair<int, int>, int> edges_;
  int n_cuts_ = 0;
  int face_ = 0;                ///< at work
  std::optional<Plane> plane_;  ///< of that, if it is a flat quad
};

Cage::Cage(const PolygonMesh& mesh) : n_vertices_(mesh.n_vertices()) {
  require_closed_cage(mesh);
  const Eigen::AlignedBox3d box = surface_box(mesh);
  size_ = box.diagonal().norm();
  center_ = box.center().transpose();
  sides_ = box.sizes().transpose() / size_;
  vertices_ = (mesh.positions().rowwise() - center_) / size_;
  double volume = 0;
  for (int f = 0; f < mesh.n_faces(); ++f)
    volume += twice_vector_area(vertices_, mesh.face(f)).dot(vertices_.row(mesh.face(f)[0])) / 6;
  constexpr double kLeastVolume = 1e-12;
  if (!(std::abs(volume) > kLeastVolume))
    throw InvalidInput("the cage encloses no volume, so nothing is inside of it; make it thicker");
  Builder builder(*this);
  for (int f = 0; f < mesh.n_faces(); ++f) {
    std::vector<int> face(mesh.face(f).begin(), mesh.face(f).end());
    if (volume < 0) std::reverse(face.begin(), face.end());
    builder.add_face(face, f);
  }
}

CageView Cage::view() const {
  return {edges_.data(), triangles_.data(), vertices_.data(), n_vertices_, static_cast<int>(edges_.size()),
          n_triangles()};
}

TrianglePlace::TrianglePlace(const CageTriangle& triangle, const Row& point)
    : depth(Row::Map(triangle.depth).dot(point) + triangle.depth[3]), heights{}, per_height(triangle.per_height) {
  for (int k = 0; k < 3; ++k) heights[k] = Row::Map(triangle.heights[k]).dot(point) + triangle.heights[k][3];
}

bool TrianglePlace::is_on() const {
  constexpr double kRounding = 1e-12;
  return std::abs(depth) <= kRounding && std::all_of(heights, heights + 3, [](double h) { return h >= -kRounding; });
}

double of_corner(const CageTriangle& triangle, const TrianglePlace& place, int corner, double of_area,
                 const double* of_edges) {
  const int next = (corner + 1) % 3;
  const int last = (corner + 2) % 3;
  const double along =
      of_edges[corner] + triangle.cosines[last] * of_edges[next] + triangle.cosines[next] * of_edges[last];
  return triangle.per_height[corner] * (place.heights[corner] * of_area + place.depth * along);
}

}  // namespace arap
