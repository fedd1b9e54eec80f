// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/polygon_ears.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "support/meshes.h"

namespace arap_test {
namespace {

using Row = Eigen::RowVector3d;
using Triangles = std::vector<std::array<int, 3>>;

Triangles cut(const Positions& points) {
  std::vector<int> face(points.rows());
  std::iota(face.begin(), face.end(), 0);
  Triangles triangles;
  arap::EarCutter().cut(points, face, triangles);
  EXPECT_EQ(triangles.size(), face.size() - 2);
  return triangles;
}

Row doubled_area(const Positions& points, const std::array<int, 3>& t) {
  return Row(points.row(t[1]) - points.row(t[0])).cross(Row(points.row(t[2]) - points.row(t[0])));
}

/// Of a face whose triangles overlap nothing, the areas sum to its own.
void expect_tiled(const Positions& points, double area) {
  double sum = 0;
  std::set<int> used;
  for (const auto& t : cut(points)) {
    sum += doubled_area(points, t).norm() / 2;
    used.insert(t.begin(), t.end());
  }
  EXPECT_NEAR(sum, area, 1e-9 * area);
  EXPECT_EQ(static_cast<Eigen::Index>(used.size()), points.rows());
}

/// A polygon around the origin, with a radius a corner, turned in space.
Positions around(const std::vector<double>& radii, int first, bool is_reversed) {
  const auto n = static_cast<int>(radii.size());
  const Matrix3 turn = rotation_about(Vector3(1, 2, 3), 2);
  Positions points(n, 3);
  for (int k = 0; k < n; ++k) {
    const int at = (is_reversed ? n - k : k + first) % n;
    const double angle = 2 * 3.14159265358979 * at / n;
    points.row(k) = (turn * Vector3(radii[at] * std::cos(angle), radii[at] * std::sin(angle), 0)).transpose();
  }
  return points;
}

double area_around(const std::vector<double>& radii) {
  double sum = 0;
  for (size_t k = 0; k < radii.size(); ++k)
    sum += radii[k] * radii[(k + 1) % radii.size()] / 2 *
           std::sin(2 * 3.14159265358979 / static_cast<double>(radii.size()));
  return sum;
}

TEST(PolygonEars, TileConcaveFacesFromAnyCorner) {
  Random random(4);
  for (const int n : {4, 5, 6, 9, 40, 1000})
    for (int round = 0; round < 8; ++round) {
      std::vector<double> radii(n);
      for (double& radius : radii) radius = random.uniform(.1, 1);
      if (n > 4)
        expect_tiled(around(radii, round, round % 2 == 1), area_around(radii));
      else
        expect_tiled(around({1, .2, 1, 1.5}, round % 4, round % 2 == 1), area_around({1, .2, 1, 1.5}));
    }
}

TEST(PolygonEars, HaveTheSideOfTheirFace) {
  const Positions points = around({1, .2, 1, .3, 2, .1, .4}, 2, false);
  const Row front = rotation_about(Vector3(1, 2, 3), 2).col(2).transpose();
  for (const auto& t : cut(points)) EXPECT_GT(doubled_area(points, t).dot(front), 0);
}

/// A spiral corridor: most of its convex corners have others in their triangles.
TEST(PolygonEars, TileASpiral) {
  constexpr int kTurns = 12;
  constexpr int kOfATurn = 5;
  Positions points(2 * kTurns * kOfATurn, 3);
  double area = 0;
  const auto n = static_cast<int>(points.rows()) / 2;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * 3.14159265358979 * k / kOfATurn;
    const double radius = 1 + .2 * k;
    points.row(k) = Row(radius * std::cos(angle), radius * std::sin(angle), 0);
    points.row(2 * n - 1 - k) = points.row(k) * (1 + .3 / radius);
  }
  for (int k = 0; k < 2 * n; ++k) {
    const Row a = points.row(k);
    const Row b = points.row((k + 1) % (2 * n));
    area += (a[0] * b[1] - a[1] * b[0]) / 2;
  }
  expect_tiled(points, std::abs(area));
}

/// Two squares that a cut of no width joins, and corners on a line.
TEST(PolygonEars, TileAFaceThatTouchesItself) {
  Positions points(12, 3);
  points << 0, 0, 0, 1, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 0, 0, 0, .5, .5, 0, .5, 1.5, 0, 1.5, 1.5, 0, 1.5, .5, 0, .5,
      .5, 0, 0, 0, 0;
  expect_tiled(points.topRows(11), 3);
}

TEST(PolygonEars, AreFoundForAnyFace) {
  Random random(6);
  for (const int n : {4, 5, 8, 60}) {
    cut(random.noise(n, 1));
    cut(Positions::Zero(n, 3));
    cut(random.noise(1, 1).replicate(n, 1));
  }
}

TEST(PolygonEars, OfAQuadAreAtItsShorterDiagonal) {
  Positions kite(4, 3);
  kite << 0, 0, 0, 1, -.2, .1, 2, 0, 0, 1, .2, .1;
  for (const auto& t : cut(kite)) EXPECT_EQ(std::count(t.begin(), t.end(), 0) + std::count(t.begin(), t.end(), 2), 1);
}

}  // namespace
}  // namespace arap_test
