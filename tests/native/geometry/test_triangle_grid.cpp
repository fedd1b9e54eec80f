// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/triangle_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::TriangleGrid;

constexpr auto kEvery = [](const TriangleGrid::Triangle&) { return true; };

std::vector<TriangleGrid::Triangle> triangles_of(const MeshData& mesh) {
  std::vector<TriangleGrid::Triangle> triangles;
  for (const auto& face : triangulate(mesh).faces) triangles.push_back({face[0], face[1], face[2]});
  return triangles;
}

/// Where a ray crosses a triangle from behind: origin + distance * direction = a + u (b - a) + v (c - a). Infinite:
/// nowhere.
double crossing(const Positions& p, const TriangleGrid::Triangle& t, const Vector3& origin, const Vector3& direction) {
  Matrix3 system;
  system << direction, (p.row(t[0]) - p.row(t[1])).transpose(), (p.row(t[0]) - p.row(t[2])).transpose();
  const Vector3 solved = system.inverse() * (p.row(t[0]).transpose() - origin);
  const Vector3 normal = -system.col(1).cross(-system.col(2));
  const bool is_inside = normal.dot(direction) > 0 && solved[1] > 0 && solved[2] > 0 && solved[1] + solved[2] < 1;
  return is_inside ? solved[0] : std::numeric_limits<double>::infinity();
}

TEST(TriangleGrid, FindsWhatASearchThroughAllFinds) {
  // The triangles of the box are much larger than those of the sphere in it.
  const MeshData mesh = join(box({1, 1, 1}, Vector3(5, 5, 5), Faces::kTriangles), bumpy_sphere(3));
  const Positions p = mesh.positions();
  const std::vector<TriangleGrid::Triangle> triangles = triangles_of(mesh);
  Random random(5);
  for (const double cell_size : {.05, .3, 20.}) {
    const TriangleGrid grid(p, triangles, cell_size, 2);
    for (int k = 0; k < 200; ++k) {
      const Vector3 origin = random.vector(2);
      const Vector3 direction = random.vector(1).normalized();
      const double farthest = random.uniform(0, 3);
      double expected = farthest;
      for (const auto& t : triangles)
        if (const double distance = crossing(p, t, origin, direction); distance > 0)
          expected = std::min(expected, distance);
      const auto hit = grid.first_exit(origin.transpose(), direction.transpose(), 0, farthest, kEvery);
      EXPECT_EQ(hit.triangle >= 0, expected < farthest);
      EXPECT_NEAR(hit.distance, expected, 1e-12);
    }
  }
}

TEST(TriangleGrid, NoRaySlipsThroughAtAVertexOrAnEdge) {
  const MeshData mesh = box({4, 4, 4}, Vector3(1, 1, 1), Faces::kTriangles);
  const Positions p = mesh.positions();
  const TriangleGrid grid(p, triangles_of(mesh), .1, 1);
  for (int x = -7; x <= 7; ++x)
    for (int y = -7; y <= 7; ++y) {
      const auto hit = grid.first_exit({x / 16., y / 16., 0}, {0, 0, 1}, 0, 1, kEvery);
      EXPECT_NEAR(hit.distance, .5, 1e-12);
      EXPECT_NEAR(hit.facing, 1, 1e-12) << "from behind";
    }
}

TEST(TriangleGrid, KnowsHowOftenTrianglesWindAroundAPlace) {
  // The boxes overlap above z = 0; rays pass right through vertices and edges.
  const MeshData lower = box({4, 4, 4}, Vector3(1, 1, 1), Faces::kTriangles);
  const auto shifted = [](const Vector3& x) { return Vector3(x + Vector3(0, 0, .5)); };
  const MeshData mesh = join(lower, transformed(lower, shifted));
  const Positions p = mesh.positions();
  for (const double cell_size : {.1, .3, 5.}) {
    const TriangleGrid grid(p, triangles_of(mesh), cell_size, 1);
    for (int x = -9; x <= 9; ++x)
      for (int z = -9; z <= 17; ++z) {
        const Eigen::RowVector3d place(x / 16., .25, z / 16. + 1e-3);
        const bool is_beside = std::abs(x) >= 8;
        if (std::abs(x) == 8) continue;
        const int expected = is_beside ? 0 : (std::abs(place[2]) < .5 ? 1 : 0) + (std::abs(place[2] - .5) < .5 ? 1 : 0);
        for (int axis = 0; axis < 3; ++axis)
          for (const int along : {-1, 1})
            EXPECT_EQ(grid.winding(place, axis, along, 4, kEvery), expected) << place << ", " << axis << ", " << along;
      }
  }
}

TEST(TriangleGrid, TrianglesWithoutAreaAndThoseAlongTheRayAreNotMet) {
  Positions p(6, 3);
  p << -1, 0, 1, 1, 0, 1, 0, 0, 1, 0, -1, 0, 0, 1, 0, 0, 0, 3;
  const TriangleGrid grid(p, {{0, 1, 2}, {3, 4, 5}}, .5, 1);
  EXPECT_EQ(grid.first_exit({0, 0, -1}, {0, 0, 1}, 0, 10, kEvery).triangle, -1);
}

TEST(TriangleGrid, MeetsOnlyWhatIsAskedForAndFromBehind) {
  const auto boxes =
      join(box({1, 1, 1}, Vector3(1, 1, 1), Faces::kTriangles), box({1, 1, 1}, Vector3(1, 1, 2), Faces::kTriangles));
  const Positions p = boxes.positions();
  const TriangleGrid grid(p, triangles_of(boxes), .5, 1);
  const auto hit = grid.first_exit({.1, .2, -2}, {0, 0, 1}, 0, 10, kEvery);
  EXPECT_NEAR(hit.distance, 2.5, 1e-12) << "not where it enters the boxes";
  EXPECT_NEAR(hit.facing, 1, 1e-12);
  const auto& first = grid.triangle(hit.triangle);
  EXPECT_NEAR(grid.first_exit({.1, .2, -2}, {0, 0, 1}, 2.6, 10, kEvery).distance, 3, 1e-12);
  EXPECT_NEAR(grid.first_exit({.1, .2, -2}, {0, 0, 1}, 0, 10, [&](const auto& t) { return t != first; }).distance, 3,
              1e-12);
  EXPECT_EQ(grid.first_exit({.1, .2, -2}, {0, 0, 1}, 0, 2.4, kEvery).triangle, -1);
}

}  // namespace
}  // namespace arap_test
