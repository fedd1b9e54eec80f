// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/thickness_links.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "geometry/grid_cell.h"
#include "geometry/triangle_grid.h"
#include "mesh/surface_measures.h"
#include "mesh/surface_orientation.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

using Links = std::vector<std::pair<int, int>>;
using Row = Eigen::RowVector3d;

/// Normals are opposite if the cosine of their angle is below this.
constexpr double kOpposite = -.5;
/// Cell size of the finest grid of triangles, in radii.
constexpr double kCell = .25;
/// Vertices nearer to each other than this, in radii, may represent each other.
constexpr double kSpacing = .25;
/// Points nearer than this, in radii, are at the same place.
constexpr double kNearest = 1e-6;
/// Walls that overlap by less than this, in radii, touch.
constexpr double kTouching = 1e-3;

std::vector<TriangleGrid::Triangle> walls(const PolygonMesh& mesh, const SurfaceOrientation& orientation) {
  std::vector<TriangleGrid::Triangle> triangles;
  triangles.reserve(2 * static_cast<size_t>(mesh.n_faces()));
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    if (orientation.has_inside[mesh.part_of_vertex()[face[0]]] == 0) continue;
    for_each_in_fan(face, [&](int i, int j, int k) { triangles.push_back({i, j, k}); });
  }
  return triangles;
}

/// Selects the first vertex of each small cube, for each of six directions of normals.
class Representatives {
 public:
  Representatives(double spacing, int n)
      : per_length_(1 / spacing), keys_(std::bit_ceil(2 * static_cast<std::uint64_t>(n) + 1), 0) {}

  /// Whether the vertex is the first one.
  bool add(const Row& place, const Row& normal) {
    Eigen::Index side = 0;
    normal.cwiseAbs().maxCoeff(&side);
    auto key = static_cast<std::uint64_t>(2 * side + (normal[side] < 0 ? 1 : 0));
    for (const std::int64_t number : grid_cell(place, per_length_))
      key = mixed(key ^ static_cast<std::uint64_t>(number));
    key |= 1U;  // 0 is an empty slot
    std::uint64_t slot = key >> 8U & (keys_.size() - 1);
    while (keys_[slot] != 0 && keys_[slot] != key) slot = (slot + 1) & (keys_.size() - 1);
    const bool is_first = keys_[slot] == 0;
    keys_[slot] = key;
    return is_first;
  }

 private:
  static std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ x >> 32U) * 0xD6E8FEB86659FD93ULL;
    x = (x ^ x >> 32U) * 0xD6E8FEB86659FD93ULL;
    return x ^ x >> 32U;
  }

  double per_length_;
  std::vector<std::uint64_t> keys_;
};

std::vector<int> choose_ends(const PolygonMesh& mesh, const SurfaceOrientation& orientation, double radius) {
  Representatives representatives(kSpacing * radius, mesh.n_vertices());
  std::vector<int> ends;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const int part = mesh.part_of_vertex()[v];
    if (part < 0 || orientation.has_inside[part] == 0 || orientation.is_manifold[v] == 0) continue;
    const Row normal = orientation.normals.row(v);
    if (!normal.isZero() && representatives.add(mesh.positions().row(v), normal)) ends.push_back(v);
  }
  return ends;
}

/// Casts rays from vertices through the inside.
class Crossing {
  /// Tests for triangles of the vertex' component that do not touch the vertex.
  [[nodiscard]] auto is_of_part(int vertex) const {
    return [this, vertex, part = mesh_.part_of_vertex()[vertex]](const TriangleGrid::Triangle& triangle) {
      return std::find(triangle.begin(), triangle.end(), vertex) == triangle.end() &&
             (mesh_.n_parts() == 1 || mesh_.part_of_vertex()[triangle[0]] == part);
    };
  }

 public:
  Crossing(const PolygonMesh& mesh, const SurfaceOrientation& orientation, double radius, int threads)
      : mesh_(mesh),
        orientation_(orientation),
        radius_(radius),
        grid_(mesh.positions(), walls(mesh, orientation), kCell * radius, threads),
        box_(surface_box(mesh)) {}

  /// The nearest corner of the triangle opposite to a vertex; -1 for none.
  [[nodiscard]] int opposite(int vertex) const {
    const Row normal = orientation_.normals.row(vertex);
    const Row place = mesh_.positions().row(vertex);
    const TriangleGrid::Hit hit = grid_.first_exit(place, -normal, kNearest * radius_, radius_, is_of_part(vertex));
    if (hit.triangle < 0 || hit.facing < -kOpposite) return -1;
    const int end = nearest_end(vertex, grid_.triangle(hit.triangle));
    if (end < 0 || overlaps(vertex, hit.distance)) return -1;
    return end;
  }

 private:
  [[nodiscard]] int nearest_end(int vertex, const TriangleGrid::Triangle& ends) const {
    int nearest = -1;
    double squared = radius_ * radius_;
    for (const int end : ends) {
      const Row across = mesh_.positions().row(end) - mesh_.positions().row(vertex);
      if (!(across.squaredNorm() < squared) || !is_opposite(vertex, end, across)) continue;
      squared = across.squaredNorm();
      nearest = end;
    }
    return nearest;
  }

  [[nodiscard]] bool is_opposite(int vertex, int end, const Row& across) const {
    const Row normal = orientation_.normals.row(vertex);
    const Row other = orientation_.normals.row(end);
    return orientation_.is_manifold[end] != 0 && normal.dot(other) < kOpposite && across.dot(normal) < 0 &&
           across.dot(other) > 0;
  }

  /// Whether another limb overlaps the ray from a vertex to the first wall through which it leaves: then that wall may
  /// belong to either limb.
  [[nodiscard]] bool overlaps(int vertex, double distance) const {
    const Row normal = orientation_.normals.row(vertex);
    const Row place = mesh_.positions().row(vertex);
    // The ray enters another limb where the reversed ray leaves it.
    const double touching = kTouching * radius_;
    const TriangleGrid::Hit entry =
        grid_.first_exit(place - distance * normal, normal, touching, distance - touching, is_of_part(vertex));
    return entry.triangle >= 0 || is_inside_twice(place - distance / 2 * normal, mesh_.part_of_vertex()[vertex]);
  }

  [[nodiscard]] bool is_inside_twice(const Row& place, int part) const {
    const Row below = place - box_.min().transpose();
    const Row above = box_.max().transpose() - place;
    Eigen::Index low = 0;
    Eigen::Index high = 0;
    const int along = above.minCoeff(&high) < below.minCoeff(&low) ? 1 : -1;
    const auto axis = static_cast<int>(along > 0 ? high : low);
    // Some faces may be missing or bad: rays in both directions must agree.
    return winding(place, part, axis, along, along > 0 ? above[axis] : below[axis]) > 1 &&
           winding(place, part, axis, -along, along > 0 ? below[axis] : above[axis]) > 1;
  }

  [[nodiscard]] int winding(const Row& place, int part, int axis, int along, double reach) const {
    return grid_.winding(place, axis, along, reach, [&](const TriangleGrid::Triangle& triangle) {
      return mesh_.n_parts() == 1 || mesh_.part_of_vertex()[triangle[0]] == part;
    });
  }

  const PolygonMesh& mesh_;
  const SurfaceOrientation& orientation_;
  double radius_;
  TriangleGrid grid_;
  Eigen::AlignedBox3d box_;
};

void sort_unique(Links& links) {
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
}

}  // namespace

Links find_thickness_links(const PolygonMesh& mesh, double radius, const std::vector<std::vector<int>>& mirrors,
                           int threads, const MeterPart& meter) {
  const SurfaceOrientation orientation = find_orientation(mesh, threads);
  meter.add(0.3);
  const std::vector<int> ends = choose_ends(mesh, orientation, radius);
  meter.add(0.1);
  if (ends.empty()) return {};
  const Crossing crossing(mesh, orientation, radius, threads);
  meter.add(0.3);
  std::vector<int> found(ends.size());
  const auto n_ends = static_cast<int>(ends.size());
  parallel_for(threads, n_ends, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) found[k] = crossing.opposite(ends[k]);
    meter.add(0.3 * (end - begin) / n_ends);
  });
  Links links;
  for (size_t k = 0; k < ends.size(); ++k)
    if (found[k] >= 0) links.emplace_back(std::minmax(ends[k], found[k]));
  sort_unique(links);
  for (const std::vector<int>& mirror : mirrors) {
    for (size_t k = 0, n = links.size(); k < n; ++k)
      links.push_back(std::minmax({mirror[links[k].first], mirror[links[k].second]}));
    sort_unique(links);
  }
  return links;
}

}  // namespace arap
