// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "arap/error.h"
#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Cage;
using arap::InvalidInput;
using Row = Eigen::RowVector3d;

TEST(Cage, IsCenteredAndOfDiagonalOne) {
  const Cage cage(transformed(cube(), [](const Vector3& x) { return Vector3(4 * x + Vector3(10, 20, 30)); }).mesh());
  const Positions& p = cage.vertices();
  EXPECT_NEAR((p.colwise().maxCoeff() - p.colwise().minCoeff()).norm(), 1, 1e-15);
  EXPECT_LT((p.colwise().maxCoeff() + p.colwise().minCoeff()).norm(), 1e-15);
  EXPECT_NEAR(cage.size(), 4 * std::sqrt(3.0), 1e-14);
  EXPECT_LT((cage.to_cage(Row(10, 20, 30))).norm(), 1e-15);
}

TEST(Cage, AQuadHasBothDiagonalsAtHalfTheWeight) {
  const Cage cage(cube().mesh());
  ASSERT_EQ(cage.n_triangles(), 24);
  EXPECT_EQ(cage.edges().size(), 12 + 12);
  std::set<std::pair<int, int>> cuts;
  for (int t = 0; t < cage.n_triangles(); ++t) {
    EXPECT_EQ(cage.triangle(t).share, .5);
    cuts.emplace(cage.face_of_triangle()[t], cage.cut_of_triangle()[t]);
  }
  EXPECT_EQ(cuts.size(), 12);
}

/// The triangle that the other diagonal cuts off lies outside.
TEST(Cage, AConcaveQuadIsCutInside) {
  MeshData mesh = cube();
  const std::vector<int> top = mesh.faces.back();
  mesh.vertices[top[1]] += .7 * (mesh.vertices[top[3]] - mesh.vertices[top[1]]);
  const Cage cage(mesh.mesh());
  EXPECT_EQ(cage.n_triangles(), 22);
  for (int t = 20; t < 22; ++t) {
    EXPECT_EQ(cage.triangle(t).share, 1);
    const auto& corners = cage.triangle(t).vertices;
    for (const int end : {top[1], top[3]}) EXPECT_EQ(std::count(corners, corners + 3, end), 1);
  }
}

TEST(Cage, FrontsAreOutwards) {
  for (const MeshData& mesh : all_cages()) {
    const Row inside = Cage(mesh.mesh()).to_cage(points_inside(mesh, 1).row(0));
    for (const MeshData& either : {mesh, flipped(mesh)}) {
      const Cage cage(either.mesh());
      double volume = 0;
      for (const arap::CageTriangle& triangle : cage.triangles()) {
        const auto corner = [&](int k) { return Row(cage.vertices().row(triangle.vertices[k]) - inside); };
        const double of_triangle = corner(0).dot(corner(1).cross(corner(2)));
        volume += triangle.share * of_triangle;
        EXPECT_EQ(of_triangle > 0, arap::TrianglePlace(triangle, inside).depth > 0) << mesh.name;
      }
      EXPECT_GT(volume, 0) << mesh.name;
    }
  }
}

TEST(Cage, HatsAreOneAtTheirCorner) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    for (const arap::CageTriangle& triangle : cage.triangles())
      for (int at = 0; at < 3; ++at) {
        const arap::TrianglePlace place(triangle, cage.vertices().row(triangle.vertices[at]));
        EXPECT_NEAR(place.depth, 0, 1e-15);
        EXPECT_TRUE(place.is_on());
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(place.hat(k), k == at ? 1 : 0, 1e-14) << mesh.name;
      }
  }
}

void expect_refused(const MeshData& mesh, std::initializer_list<std::string_view> words) {
  expect_error<InvalidInput>([&] { const Cage cage(mesh.mesh()); }, words);
}

TEST(CageErrors, SayWhatIsWrong) {
  expect_refused({"points", {{0, 0, 0}, {1, 1, 1}}, {}}, {"no faces", "give it faces"});
  expect_refused({"point", {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}, {2, 1, 0}}}, {"no size"});
  MeshData open = cube();
  open.faces.pop_back();
  expect_refused(open, {"not closed", "edge from vertex", "1 face", "fill its holes"});
  MeshData turned = cube();
  std::reverse(turned.faces[2].begin(), turned.faces[2].end());
  expect_refused(turned, {"not oriented alike", "edge from vertex", "normals"});
  MeshData with_fin = cube();
  const int tip = with_fin.add_vertex({2, 0, 0});
  with_fin.faces.push_back({with_fin.faces[0][0], with_fin.faces[0][1], tip});
  expect_refused(with_fin, {"not closed", "remove what is inside"});
  expect_refused(l_prism(1), {"has 6 corners", "3 or 4", "cut it"});
  expect_refused({"leaf", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}}}, {"no volume", "thicker"});
}

/// Four faces at an edge close it, two to each side.
TEST(Cage, TwoBoxesMayTouchAtAnEdge) {
  const MeshData box = cube();
  MeshData two = box;
  for (const std::vector<int>& face : box.faces) {
    two.faces.emplace_back();
    for (const int v : face) two.faces.back().push_back(two.vertex_at(box.vertices[v] + Vector3(1, 1, 0)));
  }
  EXPECT_EQ(two.n_vertices(), 14);
  EXPECT_EQ(Cage(two.mesh()).n_triangles(), 48);
}

}  // namespace
}  // namespace arap_test
