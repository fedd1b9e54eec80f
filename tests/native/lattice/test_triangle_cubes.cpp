// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/triangle_cubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::CubeGrid;
using Row = Eigen::RowVector3d;
using Corners = std::array<Row, 3>;

CubeGrid grid() {
  CubeGrid grid;
  grid.origin.setConstant(-1.2);
  grid.size = 0.3;
  grid.counts.fill(8);
  return grid;
}

std::set<CubeGrid::Cube> cubes_of(const Corners& corners) {
  std::vector<CubeGrid::Cube> cubes;
  arap::find_cubes(grid(), corners, cubes);
  const std::set<CubeGrid::Cube> result(cubes.begin(), cubes.end());
  EXPECT_EQ(result.size(), cubes.size()) << "a cube is named twice";
  return result;
}

/// Cubes that points of the triangle are in, at least `far` from their walls.
std::set<CubeGrid::Cube> cubes_of_points(const Corners& corners, double far) {
  constexpr int kSteps = 300;
  std::set<CubeGrid::Cube> cubes;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j) {
      const Row point = (i * corners[0] + j * corners[1] + (kSteps - i - j) * corners[2]) / kSteps;
      const CubeGrid::Cube cube = grid().cube_at(point);
      const Row in_cube = (point - grid().corner(cube)) / grid().size;
      if (in_cube.minCoeff() >= far && in_cube.maxCoeff() <= 1 - far) cubes.insert(cube);
    }
  return cubes;
}

void expect_right(const Corners& corners) {
  const std::set<CubeGrid::Cube> found = cubes_of(corners);
  const std::set<CubeGrid::Cube> entered = cubes_of_points(corners, 1e-6);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), entered.begin(), entered.end()));
  // Points are 0.03 cubes apart, so the triangle comes no nearer to the middle of a cube that it was not seen in.
  for (const CubeGrid::Cube& cube : found) {
    if (entered.count(cube) == 1) continue;
    Corners seen = corners;
    const Row middle = grid().corner(cube) + Row::Constant(grid().size / 2);
    for (Row& corner : seen) corner = middle + 0.9 * (corner - middle);
    EXPECT_EQ(cubes_of_points(seen, 0.3).count(cube), 0);
  }
}

TEST(TriangleCubes, AreThoseThatPointsOfItAreIn) {
  Random random(11);
  for (int k = 0; k < 60; ++k) {
    const double size = k % 2 == 0 ? 1 : 0.2;
    const Row place = random.vector(1 - size).transpose();
    expect_right({place + random.vector(size).transpose(), place + random.vector(size).transpose(),
                  place + random.vector(size).transpose()});
  }
}

TEST(TriangleCubes, OfALineArePassedOneAfterTheOther) {
  Random random(12);
  for (int k = 0; k < 30; ++k) {
    const Row a = random.vector(1).transpose();
    const Row b = random.vector(1).transpose();
    expect_right({a, b, b});
    const auto apart = [](const CubeGrid::Cube& x, const CubeGrid::Cube& y) {
      return std::abs(x[0] - y[0]) + std::abs(x[1] - y[1]) + std::abs(x[2] - y[2]);
    };
    EXPECT_EQ(static_cast<int>(cubes_of({a, b, b}).size()), 1 + apart(grid().cube_at(a), grid().cube_at(b)));
  }
}

TEST(TriangleCubes, OfOneInAWallAreOnBothSides) {
  const double wall = -1.2 + 4 * 0.3;
  const auto cubes = cubes_of({Row(wall, .05, .05), Row(wall, .2, .05), Row(wall, .05, .2)});
  EXPECT_EQ(cubes, (std::set<CubeGrid::Cube>{{3, 4, 4}, {4, 4, 4}}));
}

}  // namespace
}  // namespace arap_test
