// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "arap/types.h"
#include "lattice/cube_grid.h"

namespace arap {

/// The cubes that a triangle (or, with two corners alike, a line) passes through, walls included.
void find_cubes(const CubeGrid& grid, const std::array<Eigen::RowVector3d, 3>& corners,
                std::vector<CubeGrid::Cube>& cubes);

}  // namespace arap
