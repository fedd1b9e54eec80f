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

using Bridges = std::vector<std::pair<int, int>>;
using Row = Eigen::RowVector3d;

/// Cosine of the angle between normals from which on they are opposite.
constexpr double kOpposite = -.5;
/// Cells of the finest grid of triangles, in radii.
constexpr double kCell = .25;
/// Vertices nearer to each other than this, in radii, may stand for each other.
constexpr double kSpacing = .25;
/// What is nearer than this, in radii, is the same place.
constexpr double kNearest = 1e-6;
/// Walls that overlap by less than this, in radii, touch.
constexpr double kTouching = 1e-3;

std::vector<TriangleGrid::Triangle> walls(const PolygonMesh& mesh, const SurfaceOrientation& orientation) {
  std::vector<TriangleGrid::Triangle> triangles;
  triangles.reserve(2 * static_cast<size_t>(mesh.n_faces()));
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    if (orientation.has_inside[mesh.part_of_vertex()[face[0]]] == 0) continue;
    for (size_t k = 1; k + 1 < face.size(); ++k) triangles.push_back({face[0], face[k], face[k + 1]});
  }
  return triangles;
}

/// The first vertex of those in a small cube whose normals point to the same of six sides.
class Representatives {
 public:
  Representatives(double spacing, int n)
      : per_length_(1 / spacing), keys_(std::bit_ceil(2 * static_cast<std::uint64_t>(n) + 1), 0) {}

  /// Whether there was none before it.
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
    if (part < 0 || orientation.has_inside[part] == 0 || orientation.is_sound[v] == 0) continue;
    const Row normal = orientation.normals.row(v);
    if (!normal.isZero() && representatives.add(mesh.positions().row(v), normal)) ends.push_back(v);
  }
  return ends;
}

/// Looks from a vertex straight through the inside.
class Crossing {
  /// Of the vertex' part, but not at the vertex.
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

  /// The nearest vertex around the place of the opposite wall; -1 for none.
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
    return orientation_.is_sound[end] != 0 && normal.dot(other) < kOpposite && across.dot(normal) < 0 &&
           across.dot(other) > 0;
  }

  /// Whether another limb of the part is on the way from a vertex through the inside, up to the first wall that the way
  /// leaves by: it is this limb's wall or the other's, and which of them cannot be told.
  [[nodiscard]] bool overlaps(int vertex, double distance) const {
    const Row normal = orientation_.normals.row(vertex);
    const Row place = mesh_.positions().row(vertex);
    // Looking back, where the way enters another limb is where the look leaves it.
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
    // A few faces may be missing or bad: a look the other way must find the same.
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

void sort_unique(Bridges& bridges) {
  std::sort(bridges.begin(), bridges.end());
  bridges.erase(std::unique(bridges.begin(), bridges.end()), bridges.end());
}

}  // namespace

Bridges find_thickness_links(const PolygonMesh& mesh, double radius, const std::vector<std::vector<int>>& mirrors,
                             int threads) {
  const SurfaceOrientation orientation = find_orientation(mesh, threads);
  const std::vector<int> ends = choose_ends(mesh, orientation, radius);
  if (ends.empty()) return {};
  const Crossing crossing(mesh, orientation, radius, threads);
  std::vector<int> found(ends.size());
  parallel_for(threads, static_cast<int>(ends.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) found[k] = crossing.opposite(ends[k]);
  });
  Bridges bridges;
  for (size_t k = 0; k < ends.size(); ++k)
    if (found[k] >= 0) bridges.emplace_back(std::minmax(ends[k], found[k]));
  sort_unique(bridges);
  for (const std::vector<int>& mirror : mirrors) {
    for (size_t k = 0, n = bridges.size(); k < n; ++k)
      bridges.push_back(std::minmax({mirror[bridges[k].first], mirror[bridges[k].second]}));
    sort_unique(bridges);
  }
  return bridges;
}

}  // namespace arap
