// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "arap/types.h"

namespace arap {

/// A box of equal cubes.
struct CubeGrid {
  using Cube = std::array<int, 3>;

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
  [[nodiscard]] Eigen::RowVector3d corner(const Cube& cube) const {
    return origin + size * Eigen::RowVector3d(cube[0], cube[1], cube[2]);
  }
};

}  // namespace arap
