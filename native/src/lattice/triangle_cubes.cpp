// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/triangle_cubes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// Whether a cube of half size `half` around the origin and a triangle are on different sides of a plane across `axis`.
bool is_apart(const Row& axis, const std::array<Row, 3>& corners, double half) {
  const double reach = half * axis.cwiseAbs().sum();
  const auto [least, most] = std::minmax({axis.dot(corners[0]), axis.dot(corners[1]), axis.dot(corners[2])});
  return least > reach || most < -reach;
}

/// [Akenine-Möller 2001, "Fast 3D triangle-box overlap testing"]: two convex bodies are apart if one of these planes is
/// between them. The walls of the cube are not tested: the triangle's box reaches this cube.
bool meets(const std::array<Row, 3>& corners, const Row& normal, double half) {
  if (is_apart(normal, corners, half)) return false;
  for (int e = 0; e < 3; ++e) {
    const Row edge = corners[(e + 1) % 3] - corners[e];
    for (int k = 0; k < 3; ++k)
      if (is_apart(Row::Unit(k).cross(edge), corners, half)) return false;
  }
  return true;
}

/// Cubes between two coordinates, walls included.
std::array<int, 2> range(const CubeGrid& grid, int axis, double least, double most) {
  const double wall = CubeGrid::kWall * grid.size;
  return {grid.along(axis, least - wall), grid.along(axis, most + wall)};
}

/// Adds the cubes of a triangle or a short line.
void add_cubes(const CubeGrid& grid, const std::array<Row, 3>& corners, std::vector<CubeGrid::Cube>& cubes) {
  const Row low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
  const Row high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  Row normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  // Of a line, also of one that is a triangle but for rounding, there is no plane.
  if (normal.norm() < 1e-9 * (high - low).squaredNorm()) normal.setZero();
  // Column by column along the axis that the plane is steepest to: a column has few cubes of it.
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const std::array<int, 2> across{(axis + 1) % 3, (axis + 2) % 3};
  const auto rows = range(grid, across[0], low[across[0]], high[across[0]]);
  const auto columns = range(grid, across[1], low[across[1]], high[across[1]]);
  // A little larger, so that rounding leaves no gap at walls.
  const double half = grid.size * (0.5 + CubeGrid::kWall);
  CubeGrid::Cube cube{};
  for (int i = rows[0]; i <= rows[1]; ++i)
    for (int j = columns[0]; j <= columns[1]; ++j) {
      cube[across[0]] = i;
      cube[across[1]] = j;
      double least = low[axis];
      double most = high[axis];
      if (normal[axis] != 0) {
        cube[axis] = 0;
        const Row middle = grid.corner(cube) + Row::Constant(0.5 * grid.size);
        double height = corners[0][axis];
        double reach = 0;
        for (const int k : across) {
          height -= normal[k] / normal[axis] * (middle[k] - corners[0][k]);
          reach += std::abs(normal[k] / normal[axis]) * half;
        }
        least = std::max(least, height - reach);
        most = std::min(most, height + reach);
        if (least > most) continue;
      }
      const auto layers = range(grid, axis, least, most);
      for (cube[axis] = layers[0]; cube[axis] <= layers[1]; ++cube[axis]) {
        const Row middle = grid.corner(cube) + Row::Constant(0.5 * grid.size);
        const std::array<Row, 3> seen{corners[0] - middle, corners[1] - middle, corners[2] - middle};
        if (meets(seen, normal, half)) cubes.push_back(cube);
      }
    }
}

}  // namespace

void find_cubes(const CubeGrid& grid, const std::array<Row, 3>& corners, std::vector<CubeGrid::Cube>& cubes) {
  cubes.clear();
  if (corners[1] != corners[2]) {
    add_cubes(grid, corners, cubes);
    return;
  }
  // A line, piece by piece: the box around the whole has far more cubes.
  const Row way = corners[1] - corners[0];
  const auto n = static_cast<int>(std::ceil(way.norm() / grid.size)) + 1;
  for (int k = 0; k < n; ++k) {
    const Row begin = corners[0] + way * k / n;
    const Row end = corners[0] + way * (k + 1) / n;
    add_cubes(grid, {begin, end, end}, cubes);
  }
  std::sort(cubes.begin(), cubes.end());
  cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
}

}  // namespace arap
