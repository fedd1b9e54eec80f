// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "arap/types.h"

namespace arap {

/// A box of equal cubes.
struct CubeGrid {
  using Cube = std::array<int, 3>;
  /// What is nearer to a wall than this is on it, as a fraction of a cube.
  static constexpr double kWall = 1e-9;

  Eigen::RowVector3d origin = Eigen::RowVector3d::Zero();  ///< lowest corner
  double size = 1;                                         ///< of a cube
  Cube counts{};                                           ///< cubes along each axis

  [[nodiscard]] int index(const Cube& cube) const { return (cube[0] * counts[1] + cube[1]) * counts[2] + cube[2]; }
  [[nodiscard]] Cube cube(int index) const {
    return {index / (counts[1] * counts[2]), index / counts[2] % counts[1], index % counts[2]};
  }
  /// The cube that a point is in; of points outside the nearest one.
  [[nodiscard]] Cube cube_at(const Eigen::RowVector3d& point) const {
    Cube cube{};
    for (int k = 0; k < 3; ++k) cube[k] = along(k, point[k]);
    return cube;
  }
  [[nodiscard]] int along(int axis, double coordinate) const {
    return static_cast<int>(std::clamp(std::floor((coordinate - origin[axis]) / size), 0.0, counts[axis] - 1.0));
  }
  /// Whether a point is in a cube or on its walls, but for rounding.
  [[nodiscard]] bool touches(const Cube& cube, const Eigen::RowVector3d& point) const {
    const Eigen::Array<double, 1, 3> place = (point - corner(cube)).array() / size;
    return (place >= -kWall && place <= 1 + kWall).all();
  }
  [[nodiscard]] Eigen::RowVector3d corner(const Cube& cube) const {
    return origin + size * Eigen::RowVector3d(cube[0], cube[1], cube[2]);
  }
};

/// Cubes around a box. Their number along each axis is odd: the middle of the box is the middle of a cube. So mirror
/// planes through it pass between the samples, and what is smaller than a cube is in one.
[[nodiscard]] inline CubeGrid grid_around(const Eigen::AlignedBox3d& box, double cube_size) {
  CubeGrid grid;
  grid.size = cube_size;
  for (int k = 0; k < 3; ++k) {
    const auto n = static_cast<int>(std::ceil(box.sizes()[k] / cube_size + 1e-6));
    grid.counts[k] = n + 1 - n % 2;
    grid.origin[k] = box.center()[k] - 0.5 * grid.counts[k] * cube_size;
  }
  return grid;
}

}  // namespace arap
