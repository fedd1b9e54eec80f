// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "arap/types.h"

namespace arap {

/// Indices of a cell of a regular grid.
using GridCell = std::array<std::int64_t, 3>;

/// The cell that contains a point. All points farther than 2^62 cells from the origin are in the outermost cells.
/// @param per_length  cells per unit of length
[[nodiscard]] inline GridCell grid_cell(const Eigen::RowVector3d& place, double per_length) {
  constexpr double kOutermost = 0x1p62;
  const auto along = [&](double coordinate) {
    return static_cast<std::int64_t>(std::clamp(std::floor(coordinate * per_length), -kOutermost, kOutermost));
  };
  return {along(place[0]), along(place[1]), along(place[2])};
}

/// Calls visit(cell) for every cell of a box, both corners included.
template <class Visit>
void for_each_cell(const GridCell& low, const GridCell& high, const Visit& visit) {
  for (std::int64_t x = low[0]; x <= high[0]; ++x)
    for (std::int64_t y = low[1]; y <= high[1]; ++y)
      for (std::int64_t z = low[2]; z <= high[2]; ++z) visit(GridCell{x, y, z});
}

/// A hash whose low bits differ for neighbouring cells.
[[nodiscard]] inline std::uint64_t grid_hash(const GridCell& cell, int level = 0) {
  const std::uint64_t mixed = static_cast<std::uint64_t>(cell[0]) * 0x9E3779B97F4A7C15ULL ^
                              static_cast<std::uint64_t>(cell[1]) * 0xC2B2AE3D27D4EB4FULL ^
                              static_cast<std::uint64_t>(cell[2]) * 0x165667B19E3779F9ULL ^
                              static_cast<std::uint64_t>(level) * 0xD6E8FEB86659FD93ULL;
  return mixed ^ mixed >> 32U;
}

}  // namespace arap
