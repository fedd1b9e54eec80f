// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "arap/types.h"
#include "lattice/cube_grid.h"
#include "lattice/line_crossings.h"
#include "parallel/meter.h"

namespace arap {

/// Lines of samples along each axis of a cube.
inline constexpr int kSamplesAlong = 4;

/// Samples of a cube, a bit each.
using SampleBits = std::uint64_t;

/// Number of a sample's bit in its cube.
[[nodiscard]] inline int bit_of(const std::array<int, 3>& sample) {
  return ((sample[0] % kSamplesAlong) * kSamplesAlong + sample[1] % kSamplesAlong) * kSamplesAlong +
         sample[2] % kSamplesAlong;
}

/// The cube of a sample.
[[nodiscard]] inline CubeGrid::Cube cube_of(const std::array<int, 3>& sample) {
  return {sample[0] / kSamplesAlong, sample[1] / kSamplesAlong, sample[2] / kSamplesAlong};
}

/// The sample on a line along an axis.
[[nodiscard]] inline std::array<int, 3> sample_on(const std::array<int, 2>& line, int axis, int k) {
  std::array<int, 3> sample{};
  sample[axis] = k;
  sample[(axis + 1) % 3] = line[0];
  sample[(axis + 2) % 3] = line[1];
  return sample;
}

/// Which samples are inside a connected surface. A sample is, if most of six rays along the axes leave the surface once
/// more than they enter it. So the surface may have holes, meet itself, or be turned inside out.
///
/// A sheet has no inside, whatever bowls it makes: an open surface that is little larger than its opening, or that has
/// bowls on both sides. The same goes for a surface between whose walls are more than two million cubes: time and
/// memory hang on the cubes that are between walls, not on the box around them.
struct InsideSamples {
  SampleBox samples;                               ///< of the whole grid
  std::array<std::vector<Crossing>, 3> crossings;  ///< of the lines along each axis
  int orientation = 1;                             ///< -1: the surface is turned inside out
  std::vector<int> cubes;                          ///< that have samples inside, in ascending order
  std::vector<SampleBits> bits;                    ///< of them

  /// @param points  (n, 3), within the grid
  InsideSamples(const Positions& points, const std::vector<std::array<int, 3>>& triangles, const CubeGrid& grid,
                const MeterPart& meter);

  /// Which of `cubes` it is; -1: none.
  [[nodiscard]] int find(int cube) const;
};

}  // namespace arap
