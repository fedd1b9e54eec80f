// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/line_crossings.h"

#include <gtest/gtest.h>

#include <map>

#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::Crossing;
using arap::SampleBox;

std::vector<std::array<int, 3>> triangles_of(const MeshData& mesh) {
  std::vector<std::array<int, 3>> triangles;
  for (const std::vector<int>& face : triangulate(mesh).faces) triangles.push_back({face[0], face[1], face[2]});
  return triangles;
}

/// From -1.5 to 1.5 along each axis.
SampleBox samples(double first, double spacing) {
  SampleBox box;
  box.first.setConstant(first);
  box.spacing = spacing;
  box.counts.fill(static_cast<int>(3 / spacing) + 1);
  return box;
}

/// A lattice whose lines meet corners, edges and whole faces of a unit cube: all coordinates are multiples of a
/// quarter.
TEST(LineCrossings, OfAClosedSurfaceAreAsManyOutwardsAsInwards) {
  for (const MeshData& mesh : {cube(), tetrahedron(), box({2, 2, 4}, {1, 1, 2}, Faces::kTriangles), icosphere(1)})
    for (const double first : {-1.5, -1.4})
      for (int axis = 0; axis < 3; ++axis) {
        std::map<std::array<int, 2>, int> sums;
        const auto crossings = find_crossings(mesh.positions(), triangles_of(mesh), samples(first, 0.25), axis);
        EXPECT_FALSE(crossings.empty());
        for (const Crossing& crossing : crossings) sums[crossing.line] += crossing.sign;
        for (const auto& [line, sum] : sums) EXPECT_EQ(sum, 0) << mesh.name << " " << line[0] << ", " << line[1];
      }
}

/// Corners on lines, up to rounding.
TEST(LineCrossings, RoundingLosesNone) {
  Random random(2);
  for (int k = 0; k < 300; ++k) {
    const SampleBox box = samples(-1.5 + random.uniform(0, .1), random.uniform(.1, .2));
    MeshData pyramid = tetrahedron();
    for (Vector3& corner : pyramid.vertices) corner = random.vector(1);
    pyramid.vertices[0] = box.place({4, 5, 6}).transpose();
    for (int axis = 0; axis < 3; ++axis) {
      std::map<std::array<int, 2>, int> sums;
      for (const Crossing& crossing : find_crossings(pyramid.positions(), triangles_of(pyramid), box, axis))
        sums[crossing.line] += crossing.sign;
      for (const auto& [line, sum] : sums) EXPECT_EQ(sum, 0) << k;
    }
  }
}

TEST(LineCrossings, OfACubeAreAtItsWalls) {
  const MeshData mesh = cube();
  const SampleBox box = samples(-1.45, 0.1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto crossings = find_crossings(mesh.positions(), triangles_of(mesh), box, axis);
    EXPECT_EQ(crossings.size(), 2 * 10 * 10);
    for (size_t k = 0; k < crossings.size(); ++k) {
      const bool is_exit = k % 2 == 1;
      EXPECT_EQ(crossings[k].sign, is_exit ? 1 : -1);
      EXPECT_NEAR(crossings[k].place, is_exit ? 0.5 : -0.5, 1e-12);
      EXPECT_EQ(crossings[k].before, is_exit ? 19 : 9);
    }
  }
}

}  // namespace
}  // namespace arap_test
