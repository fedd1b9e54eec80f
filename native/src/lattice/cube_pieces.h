// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "arap/types.h"
#include "lattice/cube_grid.h"
#include "lattice/inside_samples.h"
#include "parallel/meter.h"

namespace arap {

/// What a connected surface and its inside are within each cube. In a cube they may be of several pieces, as two
/// fingers are: each moves by itself.
struct CubePieces {
  std::vector<int> cubes;                   ///< of each piece, its index in the grid
  std::vector<SampleBits> samples;          ///< of each piece, which samples of its cube are inside of it
  std::vector<std::pair<int, int>> beside;  ///< pieces of cubes side by side that hang together; each pair once
  std::vector<int> piece_of_vertex;         ///< (n,)

  [[nodiscard]] int size() const { return static_cast<int>(cubes.size()); }
};

/// What is inside: see InsideSamples. Shells that only lines join (triangles of two vertices) hang together by the wall
/// between them, however thin it is, and those without one along the lines.
/// @param points     (n, 3), within the grid
/// @param triangles  of a connected surface that has all these points
[[nodiscard]] CubePieces find_pieces(const Positions& points, const std::vector<std::array<int, 3>>& triangles,
                                     const CubeGrid& grid, const MeterPart& meter);

}  // namespace arap
