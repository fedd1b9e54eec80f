// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "geometry/duplicate_points.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InvalidInput;
using arap::PolygonMesh;

Positions square() { return Positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}; }

TEST(PolygonMesh, FacesComeBackAsTheyWentIn) {
  const PolygonMesh mesh(Positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}}, {0, 1, 2, 3, 2, 1, 4},
                         {4, 3});
  EXPECT_EQ(mesh.n_vertices(), 5);
  EXPECT_EQ(mesh.n_faces(), 2);
  const auto face = [&](int f) { return std::vector<int>(mesh.face(f).begin(), mesh.face(f).end()); };
  EXPECT_EQ(face(0), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(face(1), (std::vector<int>{2, 1, 4}));
}

TEST(PolygonMesh, DiagonalIsThatOfTheBoundingBox) {
  EXPECT_DOUBLE_EQ(cube().mesh().diagonal(), std::sqrt(3.0));
  EXPECT_EQ(PolygonMesh(Positions::Constant(3, 3, 7), {0, 1, 2}, {3}).diagonal(), 0);
}

TEST(PolygonMesh, PartsAreNumberedByTheirLowestVertex) {
  // Faces name the part with the higher vertices first.
  MeshData mesh = two_spheres(0);
  std::reverse(mesh.faces.begin(), mesh.faces.end());
  const PolygonMesh built = mesh.mesh();
  EXPECT_EQ(built.n_parts(), 2);
  for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(built.part_of_vertex()[v], v < 12 ? 0 : 1);
}

TEST(PolygonMesh, PartsThatShareOneVertexAreOnePart) {
  EXPECT_EQ(bow_tie().mesh().n_parts(), 1);
  EXPECT_EQ(book(2, Faces::kQuads).mesh().n_parts(), 1);
}

TEST(PolygonMesh, LooseVerticesAreListedAndBelongToNoPart) {
  const PolygonMesh mesh(Positions::Random(6, 3), {1, 3, 4}, {3});
  EXPECT_EQ(mesh.loose_vertices(), (std::vector<int>{0, 2, 5}));
  EXPECT_EQ(mesh.part_of_vertex(), (std::vector<int>{-1, 0, -1, 0, 0, -1}));
  EXPECT_EQ(mesh.n_parts(), 1);
}

TEST(PolygonMesh, EveryKindOfFaceIsAccepted) {
  for (const MeshData& mesh : all_small_meshes()) EXPECT_NO_THROW(static_cast<void>(mesh.mesh())) << mesh.name;
  EXPECT_NO_THROW(static_cast<void>(sheet_with_collinear_corners().mesh()));
  EXPECT_NO_THROW(PolygonMesh(square(), {0, 1, 2, 0, 1, 2, 2, 1, 0}, {3, 3, 3})) << "duplicate and flipped faces";
  EXPECT_NO_THROW(PolygonMesh(square(), {0, 1, 1, 2, 2, 2}, {3, 3})) << "a face that names a vertex twice";
  EXPECT_NO_THROW(PolygonMesh(square(), {}, {})) << "no faces";
}

TEST(PolygonMesh, NonFinitePositionIsRefusedByVertex) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (int axis = 0; axis < 3; ++axis) {
      Positions positions = square();
      positions(2, axis) = bad;
      expect_error<InvalidInput>(
          [&] {
            PolygonMesh(positions, {0, 1, 2}, {3});
          },
          {"rest_positions", "vertex 2", "finite"});
    }
  }
}

TEST(PolygonMesh, HugePositionIsRefusedByVertex) {
  Positions positions = square();
  positions(3, 1) = 1e300;
  expect_error<InvalidInput>([&] { PolygonMesh(positions, {0, 1, 2}, {3}); }, {"vertex 3"});
}

TEST(PolygonMesh, NoVerticesAreRefused) {
  expect_error<InvalidInput>([] { PolygonMesh(Positions(0, 3), {}, {}); }, {"rest_positions", "at least one vertex"});
}

TEST(PolygonMesh, IndexOutOfRangeIsRefusedByFace) {
  for (const int bad : {-1, 4, 1 << 30}) {
    expect_error<InvalidInput>(
        [&] {
          PolygonMesh(square(), {0, 1, 2, 0, bad, 3}, {3, 3});
        },
        {"face 1", std::to_string(bad), "0 to 3"});
  }
}

TEST(PolygonMesh, FaceOfLessThanThreeCornersIsRefused) {
  for (const int bad : {2, 1, 0, -3}) {
    expect_error<InvalidInput>(
        [&] {
          PolygonMesh(square(), {0, 1, 2, 0, 1}, {3, bad});
        },
        {"face_sizes[1]", std::to_string(bad), ">= 3"});
  }
}

TEST(PolygonMesh, FaceSizesThatDoNotAddUpAreRefusedWithBothCounts) {
  expect_error<InvalidInput>(
      [&] {
        PolygonMesh(square(), {0, 1, 2, 3}, {3});
      },
      {"corner_vertices", "4", "face_sizes", "3"});
  expect_error<InvalidInput>(
      [&] {
        PolygonMesh(square(), {0, 1, 2, 3}, {3, 3});
      },
      {"corner_vertices", "4", "face_sizes", "6"});
  const int huge = std::numeric_limits<int>::max();
  expect_error<InvalidInput>([&] { PolygonMesh(square(), {0, 1, 2, 3}, {huge, huge, huge}); }, {"face_sizes"});
}

TEST(CoincidentWith, NamesTheLowestVertexAtTheSamePlace) {
  const Positions p{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 1e-12}, {0, 0, 0}, {1, 0, 1}};
  EXPECT_EQ(arap::coincident_with(p, 1e-9, 2), (std::vector<int>{0, 1, 0, 1, 0, 5}));
}

TEST(CoincidentWith, DistanceZeroJoinsOnlyEqualPlaces) {
  const Positions p{{0, 0, 0}, {0, 0, 1e-300}, {0, 0, 0}, {-0.0, 0, 0}};
  EXPECT_EQ(arap::coincident_with(p, 0, 2), (std::vector<int>{0, 1, 0, 0}));
}

TEST(CoincidentWith, FindsPairsOnBothSidesOfEveryCell) {
  // Pairs a hair closer than the distance, all over a box that is large against it.
  Random random(5);
  constexpr int kPairs = 500;
  constexpr double kDistance = 1e-6;
  Positions p(2 * kPairs, 3);
  for (int k = 0; k < kPairs; ++k) {
    p.row(k) = random.vector(1).transpose();
    p.row(kPairs + k) = p.row(k) + .99 * kDistance * random.vector(1).transpose();
  }
  const std::vector<int> lowest = arap::coincident_with(p, kDistance, 2);
  for (int k = 0; k < kPairs; ++k) {
    EXPECT_EQ(lowest[k], k);
    EXPECT_EQ(lowest[kPairs + k], k);
  }
}

TEST(CoincidentWith, NothingCoincidesInAProperMesh) {
  for (const MeshData& mesh : all_small_meshes()) {
    const std::vector<int> lowest = arap::coincident_with(mesh.positions(), 1e-9 * mesh.diagonal(), 2);
    for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(lowest[v], v) << mesh.name;
  }
}

/// Crowded: who is near to one that is near to a third need not be near to that one.
TEST(CoincidentWith, JoinsEachToOneThatStandsForItselfOnAnyNumberOfThreads) {
  Random random(6);
  constexpr int kVertices = 2000;
  constexpr double kDistance = .02;
  Positions p(kVertices, 3);
  for (int v = 0; v < kVertices; ++v) p.row(v) = .2 * random.vector(1).transpose();
  const std::vector<int> lowest = arap::coincident_with(p, kDistance, 1);
  for (int v = 0; v < kVertices; ++v) {
    const auto is_near = [&](int u) { return (p.row(u) - p.row(v)).cwiseAbs().maxCoeff() <= kDistance; };
    EXPECT_LE(lowest[v], v);
    EXPECT_EQ(lowest[lowest[v]], lowest[v]);
    EXPECT_TRUE(is_near(lowest[v]));
    for (int u = 0; u < v && lowest[v] == v; ++u) EXPECT_FALSE(lowest[u] == u && is_near(u)) << u << ", " << v;
  }
  EXPECT_EQ(arap::coincident_with(p, kDistance, 3), lowest);
}

TEST(CoincidentWith, AllVerticesAtOnePlace) {
  EXPECT_EQ(arap::coincident_with(Positions::Constant(50, 3, 3.5), 0, 2), std::vector<int>(50, 0));
}

// Facts of the test meshes themselves, which the other tests rely on.

TEST(TestMeshes, EulerCharacteristics) {
  const auto characteristic = [](const MeshData& mesh) {
    std::set<std::pair<int, int>> edges;
    for (const auto& face : mesh.faces)
      for (size_t k = 0; k < face.size(); ++k) edges.insert(std::minmax(face[k], face[(k + 1) % face.size()]));
    return mesh.n_vertices() - static_cast<int>(edges.size()) + mesh.n_faces();
  };
  for (const MeshData& mesh : {tetrahedron(), cube(), bar(2, Faces::kTriangles), bar(2, Faces::kQuads), cylinder(8, 3),
                               l_prism(3), star_prism(5, 2), icosphere(2), bumpy_sphere(2), quad_sphere(3)})
    EXPECT_EQ(characteristic(mesh), 2) << mesh.name;
  EXPECT_EQ(characteristic(open_cylinder(8, 3, Faces::kTriangles)), 0);
  EXPECT_EQ(characteristic(moebius_strip(12, 2)), 0);
  EXPECT_EQ(characteristic(cylinder_with_open_seam(8, 3, Faces::kQuads)), 1);
  EXPECT_EQ(characteristic(two_spheres(1)), 4);
}

TEST(TestMeshes, ClosedOnesFaceOutwards) {
  for (const MeshData& mesh : {tetrahedron(), cube(), bar(2, Faces::kQuads), cylinder(8, 3), l_prism(3),
                               star_prism(5, 2), icosphere(1), bumpy_sphere(2), quad_sphere(3)}) {
    double volume = 0;
    const MeshData triangles = triangulate(mesh);
    for (const auto& t : triangles.faces)
      volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
    EXPECT_GT(volume, 0) << mesh.name;
  }
}

TEST(TestMeshes, MostTrianglesOfTheShearedCylinderAreObtuse) {
  const MeshData mesh = sheared_cylinder(12, 6);
  int obtuse = 0;
  for (const auto& t : mesh.faces) {
    for (int c = 0; c < 3; ++c) {
      const Vector3 u = mesh.vertices[t[(c + 1) % 3]] - mesh.vertices[t[c]];
      const Vector3 v = mesh.vertices[t[(c + 2) % 3]] - mesh.vertices[t[c]];
      if (u.dot(v) < 0) ++obtuse;
    }
  }
  EXPECT_GT(obtuse, mesh.n_faces() / 2);
}

TEST(TestMeshes, MirrorOfAMirrorIsTheVertexItself) {
  for (const MeshData& mesh : {bar(2, Faces::kQuads), quad_sphere(4)}) {
    const std::vector<int> mirrored = mirror_vertices(mesh);
    for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(mirrored[mirrored[v]], v);
  }
}

TEST(TestMeshes, BestRigidMotionFindsTheMotion) {
  const RigidMotion motion = Random(3).rigid_motion(2.5, 4);
  const Positions p = bumpy_sphere(1).positions();
  const RigidMotion found = best_rigid_motion(p, motion.apply(p));
  EXPECT_LT((found.rotation - motion.rotation).norm(), 1e-12);
  EXPECT_LT((found.translation - motion.translation).norm(), 1e-12);
}

TEST(TestMeshes, FlipsAreCounted) {
  const MeshData mesh = grid(4, Faces::kQuads);
  const std::vector<Matrix3> identity(static_cast<size_t>(mesh.n_vertices()), Matrix3::Identity());
  EXPECT_EQ(count_flips(mesh, mesh.positions(), identity), 0);
  Positions folded = mesh.positions();
  folded.col(0) = folded.col(0).cwiseAbs();
  EXPECT_EQ(count_flips(mesh, folded, identity), 8) << "the left half is folded over";
  const std::vector<Matrix3> turned(identity.size(), rotation_about(Vector3::UnitY(), 3.1));
  EXPECT_EQ(count_flips(mesh, mesh.positions(), turned), 16);
}

}  // namespace
}  // namespace arap_test
