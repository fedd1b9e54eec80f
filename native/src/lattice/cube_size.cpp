// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "base/format_message.h"
#include "geometry/triangle_grid.h"
#include "lattice/lattice.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// The triangles of a mesh, turned outwards, and of its parts the volumes, negative if they were inside out, and boxes.
struct FanTriangles {
  std::vector<TriangleGrid::Triangle> triangles;
  std::vector<double> areas;
  double area = 0;
  std::vector<double> volumes;
  std::vector<Eigen::AlignedBox3d> boxes;

  /// Without signs.
  [[nodiscard]] double volume() const {
    double sum = 0;
    for (const double of_part : volumes) sum += std::abs(of_part);
    return sum;
  }
};

FanTriangles make_fans(const PolygonMesh& mesh) {
  FanTriangles fans;
  fans.volumes.assign(mesh.n_parts(), 0);
  fans.boxes.resize(mesh.n_parts());
  const Positions& points = mesh.positions();
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    const int part = mesh.part_of_vertex()[face[0]];
    for (const int v : face) fans.boxes[part].extend(points.row(v).transpose());
    for (size_t k = 2; k < face.size(); ++k) {
      const Row a = points.row(face[0]);
      const Row normal = Row(points.row(face[k - 1]) - a).cross(Row(points.row(face[k]) - a));
      fans.triangles.push_back({face[0], face[k - 1], face[k]});
      fans.areas.push_back(normal.norm() / 2);
      fans.area += fans.areas.back();
      fans.volumes[part] += a.dot(normal) / 6;
    }
  }
  for (TriangleGrid::Triangle& triangle : fans.triangles)
    if (fans.volumes[mesh.part_of_vertex()[triangle[0]]] < 0) std::swap(triangle[1], triangle[2]);
  return fans;
}

/// Median over the surface of how far it is straight through to the opposite wall; 1 if there is mostly none.
double median_thickness(const Positions& points, const FanTriangles& fans, int threads) {
  constexpr int kRays = 2000;
  const TriangleGrid grid(points, fans.triangles, 0.02, threads);
  std::vector<double> thickness;
  double passed = 0;
  for (size_t t = 0; t < fans.triangles.size(); ++t) {
    const double before = std::floor(passed / fans.area * kRays);
    passed += fans.areas[t];
    const auto n_rays = static_cast<size_t>(std::floor(passed / fans.area * kRays) - before);
    if (n_rays == 0) continue;
    const auto& [a, b, c] = fans.triangles[t];
    const Row normal = Row(points.row(b) - points.row(a)).cross(Row(points.row(c) - points.row(a)));
    const auto hit = grid.first_exit((points.row(a) + points.row(b) + points.row(c)) / 3, -normal.normalized(), 1e-6, 1,
                                     [](const TriangleGrid::Triangle&) { return true; });
    thickness.insert(thickness.end(), n_rays, hit.distance);
  }
  if (thickness.empty()) return 1;
  std::nth_element(thickness.begin(), thickness.begin() + std::ssize(thickness) / 2, thickness.end());
  return thickness[thickness.size() / 2];
}

/// Smaller cubes would be too many.
double least_size(const FanTriangles& fans) {
  constexpr double kMostCubes = 25000;
  constexpr double kMostSampled = 500000;  // cubes of the parts' boxes, whose samples are searched for the inside
  const double volume = fans.volume();
  // A surface passes through about 1.5 cubes on the area of a wall.
  const auto is_enough = [&](double h) {
    double n_sampled = 0;
    for (const Eigen::AlignedBox3d& box : fans.boxes) n_sampled += ((box.sizes() / h).array() + 1).prod();
    return 1.5 * fans.area / (h * h) + volume / (h * h * h) <= kMostCubes &&
           n_sampled <= std::max(kMostSampled, 10.0 * static_cast<double>(fans.boxes.size()));
  };
  double size = 1e-3;
  while (!is_enough(size) && size < 1) size *= 1.02;
  return size;
}

}  // namespace

double choose_cube_size(const PolygonMesh& mesh, double wanted, int threads) {
  constexpr double kLargest = 0.02;
  constexpr double kAcross = 4;
  const FanTriangles fans = make_fans(mesh);
  const double least = least_size(fans);
  if (wanted > 0 && wanted < least)
    throw InvalidInput(
        text("cube_size is ", wanted, ", must be at least ", least, " for this mesh: smaller cubes would be too many"));
  if (wanted > 0) return wanted;
  const double thickness = fans.area > 0 ? median_thickness(mesh.positions(), fans, threads) : 1;
  return std::max(std::min(kLargest, thickness / kAcross), least);
}

}  // namespace arap
