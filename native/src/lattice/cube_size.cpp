// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_set>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "base/format_message.h"
#include "geometry/triangle_grid.h"
#include "lattice/lattice.h"
#include "lattice/line_triangle.h"
#include "lattice/triangle_cubes.h"
#include "mesh/polygon_ears.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// The triangles of a mesh but lines, turned outwards, and of its parts the volumes, negative if they were inside out,
/// and boxes.
struct Surface {
  std::vector<TriangleGrid::Triangle> triangles;
  std::vector<int> parts;  ///< of each triangle
  std::vector<double> areas;
  double area = 0;
  std::vector<double> volumes;
  std::vector<Eigen::AlignedBox3d> boxes;

  /// Parts are left out of what is counted.
  void leave_out(const std::vector<char>& is_left_out) {
    size_t n = 0;
    for (size_t t = 0; t < triangles.size(); ++t) {
      if (is_left_out[parts[t]] != 0) {
        area -= areas[t];
        continue;
      }
      triangles[n] = triangles[t];
      parts[n] = parts[t];
      areas[n++] = areas[t];
    }
    triangles.resize(n);
    parts.resize(n);
    areas.resize(n);
    for (size_t part = 0; part < volumes.size(); ++part)
      if (is_left_out[part] != 0) volumes[part] = 0;
  }

  /// Without signs.
  [[nodiscard]] double volume() const {
    double sum = 0;
    for (const double of_part : volumes) sum += std::abs(of_part);
    return sum;
  }
};

Surface read_surface(const PolygonMesh& mesh) {
  Surface surface;
  surface.volumes.assign(mesh.n_parts(), 0);
  surface.boxes.resize(mesh.n_parts());
  std::vector<Row> origins(mesh.n_parts());
  EarCutter ears;
  const Positions& points = mesh.positions();
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    const int part = mesh.part_of_vertex()[face[0]];
    // An open part has a volume as seen from somewhere: from itself it is least wrong.
    if (surface.boxes[part].isEmpty()) origins[part] = points.row(face[0]);
    for (const int v : face) surface.boxes[part].extend(points.row(v).transpose());
    ears.cut(points, face, surface.triangles);
    const auto first = surface.triangles.begin() + std::ssize(surface.parts);
    surface.triangles.erase(std::remove_if(first, surface.triangles.end(), is_line), surface.triangles.end());
    for (size_t t = surface.parts.size(); t < surface.triangles.size(); ++t) {
      const auto& [a, b, c] = surface.triangles[t];
      const Row normal = Row(points.row(b) - points.row(a)).cross(Row(points.row(c) - points.row(a)));
      surface.parts.push_back(part);
      surface.areas.push_back(normal.norm() / 2);
      surface.area += surface.areas.back();
      surface.volumes[part] += (points.row(a) - origins[part]).dot(normal) / 6;
    }
  }
  for (size_t t = 0; t < surface.triangles.size(); ++t)
    if (surface.volumes[surface.parts[t]] < 0) std::swap(surface.triangles[t][1], surface.triangles[t][2]);
  return surface;
}

/// How far it is straight through to the opposite wall, by part, at places all over the surface; 1 if there is none.
std::vector<std::vector<double>> thickness_of_parts(const Positions& points, const Surface& surface, int threads) {
  constexpr int kRays = 2000;
  const TriangleGrid grid(points, surface.triangles, 0.02, threads);
  std::vector<std::vector<double>> of_parts(surface.volumes.size());
  double passed = 0;
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const double before = std::floor(passed / surface.area * kRays);
    passed += surface.areas[t];
    const auto n_rays = static_cast<size_t>(std::floor(passed / surface.area * kRays) - before);
    if (n_rays == 0) continue;
    const auto& [a, b, c] = surface.triangles[t];
    const Row normal = Row(points.row(b) - points.row(a)).cross(Row(points.row(c) - points.row(a)));
    const auto hit = grid.first_exit((points.row(a) + points.row(b) + points.row(c)) / 3, -normal.normalized(), 1e-6, 1,
                                     [](const TriangleGrid::Triangle&) { return true; });
    of_parts[surface.parts[t]].insert(of_parts[surface.parts[t]].end(), n_rays, hit.distance);
  }
  return of_parts;
}

/// Parts that have mostly no opposite wall, as sheets have none.
std::vector<char> find_sheets(const std::vector<std::vector<double>>& thickness) {
  std::vector<char> is_sheet;
  for (const std::vector<double>& of_part : thickness) {
    const auto n_through = std::ranges::count_if(of_part, [](double distance) { return distance < 1; });
    is_sheet.push_back(2 * n_through < std::ssize(of_part) ? 1 : 0);
  }
  return is_sheet;
}

/// Median thickness of what is no sheet, if there is any.
std::optional<double> median_thickness(const std::vector<std::vector<double>>& of_parts,
                                       const std::vector<char>& is_sheet) {
  std::vector<double> thickness;
  for (size_t part = 0; part < of_parts.size(); ++part)
    if (is_sheet[part] == 0) thickness.insert(thickness.end(), of_parts[part].begin(), of_parts[part].end());
  if (thickness.empty()) return std::nullopt;
  std::nth_element(thickness.begin(), thickness.begin() + std::ssize(thickness) / 2, thickness.end());
  return thickness[thickness.size() / 2];
}

/// The cubes of this size that are crossed or inside, as a multiple of the most that there may be; four at the most.
double load_of(double size, const Positions& points, const Surface& surface) {
  constexpr double kMostCubes = 25000;
  constexpr double kMuch = 4;
  const double most = std::max(kMostCubes, 2.0 * static_cast<double>(surface.boxes.size()));
  const double n_inside = surface.volume() / (size * size * size);
  // A surface passes through about 1.5 cubes on the area of a wall: far too many are not counted.
  if (1.5 * surface.area / (size * size) + n_inside > 2 * kMuch * most) return kMuch;
  std::vector<CubeGrid> grids;
  grids.reserve(surface.boxes.size());
  for (const Eigen::AlignedBox3d& box : surface.boxes) grids.push_back(grid_around(box, size));
  std::unordered_set<std::int64_t> crossed;
  std::vector<CubeGrid::Cube> cubes;
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const CubeGrid& grid = grids[surface.parts[t]];
    const auto& [a, b, c] = surface.triangles[t];
    const CubeGrid::Cube first = grid.cube_at(points.row(a));
    if (first == grid.cube_at(points.row(b)) && first == grid.cube_at(points.row(c)))
      cubes.assign(1, first);
    else
      find_cubes(grid, {points.row(a), points.row(b), points.row(c)}, cubes);
    for (const CubeGrid::Cube& cube : cubes)
      crossed.insert(static_cast<std::int64_t>(surface.parts[t]) << 32 | grid.index(cube));
    if (static_cast<double>(crossed.size()) + n_inside > kMuch * most) return kMuch;
  }
  return (static_cast<double>(crossed.size()) + n_inside) / most;
}

}  // namespace

double choose_cube_size(const PolygonMesh& mesh, double wanted, int threads, const MeterPart& meter) {
  constexpr double kLargest = 0.02;
  constexpr double kSmallest = 1e-3;
  constexpr double kAcross = 4;
  Surface surface = read_surface(mesh);
  meter.tell();
  const Positions& points = mesh.positions();
  double size = wanted;
  if (!(wanted > 0)) {
    size = kLargest;
    if (surface.area > 0) {
      const auto thickness = thickness_of_parts(points, surface, threads);
      const std::vector<char> is_sheet = find_sheets(thickness);
      if (const std::optional<double> median = median_thickness(thickness, is_sheet)) {
        size = std::clamp(*median / kAcross, kSmallest, kLargest);
        surface.leave_out(is_sheet);  // they have cubes only if there is nothing else
      }
    }
  }
  // Each part fits into one cube of size 1.
  while (size < 1) {
    meter.tell();
    const double load = load_of(size, points, surface);
    if (load <= 1) break;
    // Their number falls with the cube of the size at the most.
    size = std::min(1.0, size * std::max(1.02, std::cbrt(load)));
  }
  if (wanted > 0 && size > wanted)
    throw InvalidInput(
        text("cube_size = ", wanted, ", must be at least ", size, " for this mesh: smaller cubes would be too many"));
  // Walls of round sizes would pass through vertices of even meshes, and rounding would decide on which side each is.
  constexpr double kBesideVertices = 1.0001;
  return kBesideVertices * size;
}

}  // namespace arap
