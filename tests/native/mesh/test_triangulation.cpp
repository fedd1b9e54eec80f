// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::EdgeWeights;
using arap::Triangulation;

using EdgeSums = std::map<std::pair<int, int>, double>;

/// Sum of the weights of each edge over all triangles.
EdgeSums edge_sums(const Triangulation& triangulation) {
  EdgeSums sums;
  for (const auto& t : triangulation.triangles)
    for (size_t k = 0; k < 3; ++k)
      sums[std::minmax(t.vertices[(k + 1) % 3], t.vertices[(k + 2) % 3])] += t.half_cotangents[k];
  return sums;
}

EdgeSums edge_sums(const MeshData& mesh, EdgeWeights weights = EdgeWeights::kCotangent) {
  return edge_sums(arap::triangulate(mesh.mesh(), weights));
}

/// Sum of weight (f_i - f_j)^2, which is the integral of |grad f|^2 over a flat mesh if f is linear.
double dirichlet(const EdgeSums& sums, const MeshData& mesh, const Vector3& slope) {
  double sum = 0;
  for (const auto& [ij, weight] : sums)
    sum += weight * std::pow(slope.dot(mesh.vertices[ij.first] - mesh.vertices[ij.second]), 2);
  return sum;
}

MeshData one_face(const std::vector<Vector3>& corners) {
  MeshData mesh{"one_face", corners, {{}}};
  for (int v = 0; v < mesh.n_vertices(); ++v) mesh.faces[0].push_back(v);
  return mesh;
}

TEST(HalfCotangents, AreThoseOfTheAngles) {
  const auto equilateral = arap::half_cotangents({0, 0, 0}, {1, 0, 0}, {.5, std::sqrt(3.0) / 2, 0});
  for (const double h : equilateral) EXPECT_NEAR(h, .5 / std::sqrt(3.0), 1e-15);
  const auto right = arap::half_cotangents({1, 1, 5}, {3, 1, 5}, {1, 3, 5});
  EXPECT_NEAR(right[0], 0, 1e-15);
  EXPECT_NEAR(right[1], .5, 1e-15);
  EXPECT_NEAR(right[2], .5, 1e-15);
  const auto obtuse = arap::half_cotangents({0, 0, 0}, {1, 0, 0}, {-1, 1, 0});
  EXPECT_NEAR(obtuse[0], -.5, 1e-15) << "135 degrees";
}

TEST(Triangulate, RegularTetrahedronHasWeightsOneOverSqrtThree) {
  const EdgeSums sums = edge_sums(tetrahedron());
  EXPECT_EQ(sums.size(), 6u);
  for (const auto& [ij, weight] : sums) EXPECT_NEAR(weight, 1 / std::sqrt(3.0), 1e-14);
}

TEST(Triangulate, SquareQuadIsTheFivePointStencil) {
  const int n = 4;
  const MeshData mesh = grid(n, Faces::kQuads);
  for (const auto& [ij, weight] : edge_sums(mesh)) {
    const Vector3 d = mesh.vertices[ij.first] - mesh.vertices[ij.second];
    const Vector3 middle = (mesh.vertices[ij.first] + mesh.vertices[ij.second]) / 2;
    const bool is_diagonal = d.cwiseAbs().minCoeff() == 0 && d.norm() > 1.1 / n;
    const bool is_border = std::max(std::abs(middle.x()), std::abs(middle.y())) > .499;
    EXPECT_NEAR(weight, is_diagonal ? 0 : is_border ? .5 : 1, 1e-13);
  }
}

TEST(Triangulate, DoesNotDependOnTheFirstCornerOrTheOrientation) {
  for (const MeshData& mesh : {quad_sphere(2), l_prism(1), star_prism(5, 1)}) {
    MeshData relabelled = mesh;
    for (size_t f = 0; f < relabelled.faces.size(); ++f) {
      auto& face = relabelled.faces[f];
      std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(f % face.size()), face.end());
      if (f % 2 == 0) std::reverse(face.begin(), face.end());
    }
    const EdgeSums sums = edge_sums(mesh);
    const EdgeSums others = edge_sums(relabelled);
    ASSERT_EQ(sums.size(), others.size());
    for (const auto& [ij, weight] : sums) EXPECT_NEAR(others.at(ij), weight, 1e-12) << mesh.name;
  }
}

TEST(Triangulate, UniformWeightsGiveEveryTriangleOfAFaceItsShare) {
  for (const auto& [ij, weight] : edge_sums(open_cylinder(8, 3, Faces::kTriangles), EdgeWeights::kUniform))
    EXPECT_TRUE(std::abs(weight - 1) < 1e-14 || std::abs(weight - .5) < 1e-14) << "inside 1, border 1/2";
  const MeshData mesh = cube();
  for (const auto& [ij, weight] : edge_sums(mesh, EdgeWeights::kUniform)) {
    // A quad is its four corner triangles at half weight; each side and each diagonal lies in two of them.
    const bool is_diagonal = (mesh.vertices[ij.first] - mesh.vertices[ij.second]).norm() > 1.1;
    EXPECT_NEAR(weight, is_diagonal ? .5 : 1, 1e-14);
  }
}

TEST(Triangulate, FlatConvexFaceIntegratesLinearFunctionsExactly) {
  // True for every fan, so for their average; the last ones have more corners than fans are sent.
  for (const int n : {3, 4, 5, 8, 63, 64, 65, 100, 257}) {
    std::vector<Vector3> corners;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      corners.emplace_back(2 * std::cos(angle), std::sin(angle), 0);
    }
    const MeshData mesh = one_face(corners);
    const double area = n * std::sin(2 * std::numbers::pi / n);
    const EdgeSums sums = edge_sums(mesh);
    // Fans of a polygon that is nearly a smooth curve have triangles that count as degenerate; they have no area to
    // speak of.
    EXPECT_NEAR(dirichlet(sums, mesh, Vector3::UnitX()), area, 2e-3 * area) << n;
    EXPECT_NEAR(dirichlet(sums, mesh, Vector3::UnitY()), area, 2e-3 * area) << n;
    if (n > 8) continue;
    EXPECT_NEAR(dirichlet(sums, mesh, {.6, .8, 0}), area, 1e-12 * area) << n;
  }
}

TEST(Triangulate, CostOfAFaceIsLinearInItsCorners) {
  const int n = 1000;
  std::vector<Vector3> corners;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    corners.emplace_back(std::cos(angle), std::sin(angle), .1 * std::cos(2 * angle));
  }
  const Triangulation t = arap::triangulate(one_face(corners).mesh(), EdgeWeights::kCotangent);
  EXPECT_LE(t.triangles.size() + t.ties.size(), 3 * arap::kFewestFans * n);
}

TEST(Triangulate, ConcaveFaceHasFiniteWeightsAndNoNegativeEnergy) {
  for (const MeshData& mesh : {l_prism(1), star_prism(5, 1), star_prism(7, 1)}) {
    const Triangulation triangulation = arap::triangulate(mesh.mesh(), EdgeWeights::kCotangent);
    for (const auto& t : triangulation.triangles) {
      const auto& h = t.half_cotangents;
      for (const double value : h) EXPECT_TRUE(std::isfinite(value));
      // 2x2 minors of the triangle's matrix: positive for every true triangle.
      EXPECT_GT(h[0] * h[1] + h[1] * h[2] + h[2] * h[0], 0) << mesh.name;
    }
    EXPECT_TRUE(triangulation.ties.empty()) << mesh.name;
  }
}

TEST(Triangulate, DegenerateTrianglesBecomeTies) {
  const std::vector<std::pair<const char*, std::vector<Vector3>>> cases = {
      {"collinear, a corner in the middle", {{0, 0, 0}, {2, 0, 0}, {1, 0, 0}}},
      {"collinear, oblique", {{0, 0, 0}, {3, 6, 9}, {1, 2, 3}}},
      {"two corners at one place", {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}},
      {"all at one place", {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}},
      {"needle", {{0, 0, 0}, {1, 0, 0}, {1, 1e-9, 0}}},
      {"flat needle", {{0, 0, 0}, {1, 0, 0}, {.5, 1e-9, 0}}},
      {"below the least height", {{0, 0, 0}, {1, 0, 0}, {.5, .99 * arap::kDegenerateHeight, 0}}}};
  for (const auto& [name, corners] : cases) {
    const Triangulation t = arap::triangulate(one_face(corners).mesh(), EdgeWeights::kCotangent);
    EXPECT_TRUE(t.triangles.empty()) << name;
    for (const auto& tie : t.ties) {
      EXPECT_NEAR(tie.coefficients[0] + tie.coefficients[1] + tie.coefficients[2], 0, 1e-12) << name;
      EXPECT_GT(tie.weight, 0) << name;
      EXPECT_TRUE(std::isfinite(tie.weight)) << name;
    }
  }
}

TEST(Triangulate, ThinButProperTriangleKeepsItsCotangents) {
  const Triangulation t = arap::triangulate(
      one_face({{0, 0, 0}, {1, 0, 0}, {.5, 1.01 * arap::kDegenerateHeight, 0}}).mesh(), EdgeWeights::kCotangent);
  EXPECT_FALSE(t.triangles.empty());
  EXPECT_TRUE(t.ties.empty());
}

TEST(Triangulate, FaceWithARepeatedVertexGivesFiniteWeights) {
  MeshData mesh = one_face({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  for (const std::vector<int>& face : {std::vector<int>{0, 1, 1}, {0, 0, 0}, {0, 1, 2, 1}, {0, 1, 2, 0}}) {
    mesh.faces[0] = face;
    for (const EdgeWeights weights : {EdgeWeights::kCotangent, EdgeWeights::kUniform})
      for (const auto& t : arap::triangulate(mesh.mesh(), weights).triangles)
        for (const double h : t.half_cotangents) EXPECT_TRUE(std::isfinite(h));
  }
}

}  // namespace
}  // namespace arap_test
