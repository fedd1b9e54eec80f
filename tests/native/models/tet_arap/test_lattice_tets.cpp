// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/lattice_tets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "arap/error.h"
#include "arap/tet_arap.h"
#include "support/helpers.h"
#include "support/tet_arap.h"

namespace arap_test {
namespace {

using arap::LatticeTets;

constexpr double kCube = .08;

/// Two prongs side by side on a bar, nearer to each other than a cube is large.
MeshData fork() { return prism({{0, 0}, {1, 0}, {1, 2}, {.52, 2}, {.52, .5}, {.48, .5}, {.48, 2}, {0, 2}}, .5, 4); }

/// Vertices of the surface as patches, at their places moved by `motion`.
struct Held {
  arap::ConstraintSet constraints;
  std::vector<Vector3> targets;

  void add(const LatticeTets& tets, int vertex, const RigidMotion& motion = {}) {
    const arap::Patch patch = tets.patch(vertex);
    constraints.patches.add(patch);
    targets.push_back(motion.apply(patch.rest_position));
  }
  [[nodiscard]] Positions pose(const LatticeTets& tets, const MeshData& surface) const {
    Positions rows(targets.size(), 3);
    for (size_t k = 0; k < targets.size(); ++k) rows.row(static_cast<Eigen::Index>(k)) = targets[k].transpose();
    arap::TetArap solver(tets.mesh);
    solver.set_constraints(constraints);
    Positions posed = surface.positions();
    tets.embed(solver.solve(rows, to_accuracy(1e-9, arap::InitialGuess::kHandleRotations)).positions, posed);
    return posed;
  }
};

/// There are no tetrahedra in the void, and both walls hang on those between them.
TEST(LatticeTets, OfAHollowBoxAreOnePartAroundTheVoid) {
  const MeshData outer = box({4, 4, 4}, {1, 1, 1}, Faces::kQuads);
  MeshData inner = transformed(outer, [](const Vector3& x) { return Vector3(.6 * x); });
  for (std::vector<int>& face : inner.faces) std::reverse(face.begin(), face.end());
  const LatticeTets tets = LatticeTets::around(join(outer, inner).mesh(), .05);
  EXPECT_EQ(tets.mesh.n_parts(), 1);
  EXPECT_GT(tets.mesh.positions().rowwise().lpNorm<Eigen::Infinity>().minCoeff(), .1);
}

TEST(LatticeTets, EveryVertexIsInItsTetrahedron) {
  for (const MeshData& mesh : all_small_meshes()) {
    if (mesh.mesh().diagonal() == 0) continue;
    const LatticeTets tets = LatticeTets::around(mesh.mesh(), kCube);
    Positions posed = Positions::Zero(mesh.n_vertices(), 3);
    tets.embed(tets.mesh.positions(), posed);
    EXPECT_LT(max_distance(posed, mesh.positions()), 1e-12 * mesh.diagonal()) << mesh.name;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const auto& coordinates = tets.coordinates[v];
      EXPECT_GE(*std::min_element(coordinates.begin(), coordinates.end()), 0) << mesh.name;
      EXPECT_NEAR(coordinates[0] + coordinates[1] + coordinates[2] + coordinates[3], 1, 1e-14) << mesh.name;
      EXPECT_LT((tets.patch(v).rest_position - mesh.vertices[v]).norm(), 1e-12 * mesh.diagonal()) << mesh.name;
    }
  }
}

/// How many tetrahedra have each triangle.
std::map<std::array<int, 3>, int> count_triangles(const TetMesh& mesh) {
  std::map<std::array<int, 3>, int> counts;
  for (const TetMesh::Tet& tet : mesh.tets())
    for (int left_out = 0; left_out < 4; ++left_out) {
      std::array<int, 3> triangle{};
      for (int k = 0, next = 0; k < 4; ++k)
        if (k != left_out) triangle[next++] = tet[k];
      std::sort(triangle.begin(), triangle.end());
      ++counts[triangle];
    }
  return counts;
}

TEST(LatticeTets, CubesAreCutAlikeAndShareTheirFaces) {
  const MeshData ball = icosphere(3);
  const LatticeTets tets = LatticeTets::around(ball.mesh(), kCube);
  EXPECT_EQ(tets.mesh.n_tets() % 6, 0);
  EXPECT_EQ(tets.mesh.n_parts(), 1);
  EXPECT_TRUE(tets.mesh.loose_vertices().empty());
  double volume = 0;
  for (int t = 0; t < tets.mesh.n_tets(); ++t) volume += tet_volume(tets.mesh, t);
  const double cube = std::pow(kCube * ball.diagonal(), 3);
  EXPECT_NEAR(volume / (tets.mesh.n_tets() / 6 * cube), 1, 1e-3);
  EXPECT_GT(volume, 4) << "a ball has 4.19, its inside is filled";
  // The outside of the cubes is square faces, of two triangles each; all other triangles are between two tetrahedra.
  int n_outside = 0;
  for (const auto& [triangle, n] : count_triangles(tets.mesh)) {
    EXPECT_LE(n, 2);
    n_outside += n == 1 ? 1 : 0;
  }
  EXPECT_EQ(n_outside % 2, 0);
  EXPECT_LT(n_outside / 2 * std::pow(cube, 2. / 3), 2.5 * 12.6) << "about 1.5 times the sphere, in steps";
}

TEST(LatticeTets, WhatIsNotConnectedInACubeIsNotHeldTogether) {
  const MeshData mesh = fork();
  const LatticeTets tets = LatticeTets::around(mesh.mesh(), .1);
  EXPECT_EQ(tets.mesh.n_parts(), 1);
  // Both prongs bend to the same side: the one would push the other.
  Held held;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const Vector3& x = mesh.vertices[v];
    if (x.y() < .6) held.add(tets, v);
    if (x.y() > 1.9 && x.x() < .5) held.add(tets, v, {Matrix3::Identity(), {-.4, -.1, 0}});
  }
  const Positions posed = held.pose(tets, mesh);
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.vertices[v].y() > 1.9 && mesh.vertices[v].x() > .5) {
      EXPECT_LT((posed.row(v).transpose() - mesh.vertices[v]).norm(), .1) << v;
    }
  const MeshData ball = icosphere(2);
  const MeshData two = join(ball, transformed(ball, [](const Vector3& x) { return Vector3(x + Vector3(1, 0, 0)); }));
  EXPECT_EQ(LatticeTets::around(two.mesh(), kCube).mesh.n_parts(), 2);
}

TEST(LatticeTets, ASurfaceIsPosedByThem) {
  const MeshData mesh = bar(3, Faces::kQuads);
  const LatticeTets tets = LatticeTets::around(mesh.mesh(), .1);
  const std::vector<int> low = extreme_vertices(mesh.positions(), 0, .1);
  const std::vector<int> far = extreme_vertices(mesh.positions(), 0, -.1);
  const RigidMotion motion = Random(8).rigid_motion(1, .3);
  Held together;
  for (const int v : low) together.add(tets, v, motion);
  for (const int v : far) together.add(tets, v, motion);
  EXPECT_LT(max_distance(together.pose(tets, mesh), motion.apply(mesh.positions())), 1e-7);
  Held apart;
  for (const int v : low) apart.add(tets, v);
  for (const int v : far) apart.add(tets, v, motion);
  const Positions posed = apart.pose(tets, mesh);
  for (const int v : low) EXPECT_LT((posed.row(v).transpose() - mesh.vertices[v]).norm(), 1e-8);
  for (const int v : far) EXPECT_LT((posed.row(v).transpose() - motion.apply(mesh.vertices[v])).norm(), 1e-8);
}

TEST(LatticeTets, FarFromTheOriginNoDigitsAreLost) {
  const Vector3 away(1e6, -2e6, 5e5);
  const MeshData mesh = transformed(bumpy_sphere(2), [&](const Vector3& x) { return Vector3(x + away); });
  const LatticeTets tets = LatticeTets::around(mesh.mesh(), kCube);
  Positions posed = Positions::Zero(mesh.n_vertices(), 3);
  tets.embed(tets.mesh.positions(), posed);
  EXPECT_LT(max_distance(posed, mesh.positions()), 2e-9);
}

TEST(LatticeTets, LooseVerticesStay) {
  MeshData mesh = icosphere(1);
  const int loose = mesh.add_vertex({5, 6, 7});
  const LatticeTets tets = LatticeTets::around(mesh.mesh(), .2);
  EXPECT_EQ(tets.tet_of_vertex[loose], -1);
  Positions posed = mesh.positions();
  tets.embed(2 * tets.mesh.positions(), posed);
  EXPECT_EQ(posed.row(loose), Eigen::RowVector3d(5, 6, 7));
  EXPECT_LT(max_distance(posed.topRows(loose), 2 * mesh.positions().topRows(loose)), 1e-12);
  using arap::InvalidInput;
  expect_error<InvalidInput>([&] { static_cast<void>(tets.patch(loose)); },
                             {"vertex 42", "in no face", "leave it out"});
  expect_error<InvalidInput>([&] { static_cast<void>(tets.patch(43)); }, {"vertex 43", "0 to 42"});
  Positions few(3, 3);
  expect_error<InvalidInput>([&] { tets.embed(few, posed); }, {"of_tets", "3"});
  expect_error<InvalidInput>([&] { tets.embed(tets.mesh.positions(), few); }, {"of_surface", "3", "43"});
}

TEST(LatticeTetsErrors, SayWhatIsWrong) {
  using arap::InvalidInput;
  const MeshData ball = icosphere(1);
  const auto make = [](const MeshData& mesh, double cube_size) {
    return [&mesh, cube_size] { static_cast<void>(LatticeTets::around(mesh.mesh(), cube_size)); };
  };
  expect_error<InvalidInput>(make(ball, 2), {"cube_size", "2", "0.001"});
  expect_error<InvalidInput>(make(ball, std::numeric_limits<double>::quiet_NaN()), {"cube_size", "nan"});
  expect_error<InvalidInput>(make(ball, .001), {"cube_size", "too many"});
  const MeshData points{"points", {{0, 0, 0}, {1, 1, 1}}, {}};
  expect_error<InvalidInput>(make(points, 0), {"no faces", "give it faces"});
}

}  // namespace
}  // namespace arap_test
