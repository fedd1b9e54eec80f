// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

/// The faces of a mesh with vertices of their own, moved and in single precision, and each differently rounded.
MeshData torn(const MeshData& mesh, const Vector3& motion) {
  Random random(8);
  MeshData result;
  for (const std::vector<int>& face : mesh.faces) {
    std::vector<int> corners;
    for (const int v : face) {
      Vector3 place = mesh.vertices[v] + motion;
      for (double& x : place) x = static_cast<double>(static_cast<float>(x * (1 + random.uniform(-1e-7, 1e-7))));
      corners.push_back(result.n_vertices());
      result.add_vertex(place);
    }
    result.faces.push_back(corners);
  }
  return result;
}

int n_places(const MeshData& mesh) {
  const std::vector<int> first = mesh.mesh().same_places();
  return static_cast<int>(std::set<int>(first.begin(), first.end()).size());
}

TEST(SamePlaces, AreThoseThatRoundingHasTornApart) {
  const MeshData sphere = icosphere(4);
  for (const double away : {0., 10., 1000.}) {
    const MeshData mesh = torn(sphere, away * Vector3(1, -.4, .3));
    std::set<std::vector<double>> exactly;
    for (const Vector3& p : mesh.vertices) exactly.insert({p[0], p[1], p[2]});
    EXPECT_GT(static_cast<int>(exactly.size()), 2 * sphere.n_vertices()) << "otherwise the test tests nothing";
    EXPECT_EQ(n_places(mesh), sphere.n_vertices()) << away << " away";
  }
}

TEST(SamePlaces, AreNotTheTwoSidesOfAThinWall) {
  MeshData wall = grid(20, Faces::kQuads);
  const int n = wall.n_vertices();
  const double thickness = 1e-5 * wall.diagonal();
  const MeshData side = wall;
  for (const Vector3& p : side.vertices) wall.add_vertex(p + Vector3(0, 0, thickness));
  for (const std::vector<int>& face : side.faces) {
    std::vector<int> other;
    for (const int v : face) other.push_back(n + v);
    wall.faces.push_back(other);
  }
  EXPECT_EQ(n_places(wall), wall.n_vertices());
}

MeshData moved(MeshData mesh, const Vector3& motion) {
  for (Vector3& place : mesh.vertices) place += motion;
  return mesh;
}

/// A map in metres is some thousand kilometres from the origin, and doubles have its millimetres there.
TEST(SamePlaces, OfDoublesAreAsFineFarFromTheOrigin) {
  const MeshData sphere = icosphere(4);
  for (const double away : {1e4, 5.4e6, 1e9}) {
    const MeshData mesh = moved(sphere, away * Vector3(1, -.4, 0));
    EXPECT_EQ(n_places(mesh), sphere.n_vertices()) << away << " away";
    EXPECT_EQ(n_places(join(mesh, moved(mesh, 2e-7 * Vector3::Ones()))), sphere.n_vertices()) << away << " away";
  }
}

/// Whole metres are singles, too, but nothing has rounded them.
TEST(SamePlaces, OfWholeMetresAreAsFineFarFromTheOrigin) {
  const MeshData blocks = box({20, 10, 6}, {20, 10, 6}, Faces::kQuads);
  EXPECT_EQ(n_places(moved(blocks, {500000, 5400000, 0})), blocks.n_vertices());
}

/// Terrain in metres of a map's zone, `cells` along each side, in single precision.
MeshData terrain(int cells, double spacing) {
  Random random(4);
  MeshData mesh = grid(cells, Faces::kQuads, [&](double, double) { return random.uniform(0, 1); });
  for (Vector3& place : mesh.vertices) {
    place = Vector3(cells * spacing * place[0] + 500000, cells * spacing * place[1] + 5400000, 300 + place[2]);
    place = place.cast<float>().cast<double>();
  }
  return mesh;
}

/// There single precision has half metres, and no more.
TEST(SamePlaces, OfTerrainAreNotTheEndsOfItsEdges) {
  const MeshData halves = terrain(150, .5);
  EXPECT_EQ(n_places(halves), halves.n_vertices());
  const MeshData apart = torn(terrain(40, 20), Vector3::Zero());
  EXPECT_EQ(n_places(apart), 41 * 41);
}

/// As the quads at the poles of a globe are in some files: their edges there are rounding alone.
TEST(SamePlaces, AreTheCornersOfAFaceThatCoincide) {
  MeshData globe = icosphere(3);
  for (std::vector<int>& face : globe.faces)
    if (face[0] < 60) face.push_back(face[0]);
  const MeshData mesh = torn(globe, 1000 * Vector3(1, -.4, .3));
  EXPECT_EQ(n_places(mesh), globe.n_vertices());
}

/// However coarse single precision is there, a mesh does not vanish.
TEST(SamePlaces, AreNotTheWholeMesh) {
  MeshData mesh = moved(cube(), {5e6, 5e6, 5e6});
  for (const Vector3& place : mesh.vertices) ASSERT_EQ(place, Vector3(place.cast<float>().cast<double>()));
  EXPECT_EQ(n_places(mesh), mesh.n_vertices());
}

/// However far a loose vertex is away.
TEST(SamePlaces, DoNotDependOnLooseVertices) {
  MeshData mesh = torn(icosphere(2), Vector3::Zero());
  const int expected = n_places(mesh);
  mesh.add_vertex(Vector3(1e99, 0, 0));
  EXPECT_EQ(n_places(mesh), expected + 1);
}

/// The faces of a closed mesh apart are as many parts, which are one if places are joined.
TEST(SamePlaces, TellHowManyPartsThereWouldBe) {
  const MeshData sphere = icosphere(1);
  const MeshData mesh = torn(sphere, Vector3::Zero());
  EXPECT_EQ(mesh.mesh().n_parts(), sphere.n_faces());
  EXPECT_EQ(mesh.mesh().n_parts_joined(), 1);
  EXPECT_EQ(sphere.mesh().n_parts_joined(), 1);
  EXPECT_EQ(two_spheres(1).mesh().n_parts_joined(), 2);
  EXPECT_EQ(torn(two_spheres(1), Vector3::Zero()).mesh().n_parts_joined(2), 2);
}

/// Neither at their own places nor as what two parts have in common.
TEST(SamePlaces, OfLooseVerticesJoinNothing) {
  MeshData mesh = two_spheres(1);
  const int n = mesh.n_vertices();
  const std::vector<Vector3> loose = mesh.vertices;
  mesh.vertices.insert(mesh.vertices.begin(), loose.begin(), loose.end());
  for (std::vector<int>& face : mesh.faces)
    for (int& v : face) v += n;
  EXPECT_EQ(mesh.mesh().n_parts_joined(), 2);
  EXPECT_EQ(arap::PolygonMesh(mesh.positions(), {}, {}).n_parts_joined(), 0);
}

}  // namespace
}  // namespace arap_test
