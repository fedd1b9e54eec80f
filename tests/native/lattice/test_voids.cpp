// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/voids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

MeshData turned(MeshData mesh) {
  for (std::vector<int>& face : mesh.faces) std::reverse(face.begin(), face.end());
  return mesh;
}

MeshData sphere(double radius, const Vector3& center = Vector3::Zero()) {
  return transformed(icosphere(2), [&](const Vector3& x) { return Vector3(radius * x + center); });
}

MeshData all_of(const std::vector<MeshData>& meshes) {
  MeshData result = meshes[0];
  for (size_t k = 1; k < meshes.size(); ++k) result = join(result, meshes[k]);
  return result;
}

/// Part of each of some spheres.
std::vector<int> parts_of(const std::vector<MeshData>& spheres) {
  const arap::PolygonMesh mesh = arap::join_voids(in_model_space(all_of(spheres)).mesh());
  std::vector<int> result;
  int vertex = 0;
  for (const MeshData& each : spheres) {
    result.push_back(mesh.part_of_vertex()[vertex]);
    vertex += each.n_vertices();
  }
  return result;
}

using Parts = std::vector<int>;

TEST(Voids, AreOneWithTheShellAround) {
  EXPECT_EQ(parts_of({sphere(1), turned(sphere(.7))}), (Parts{0, 0}));
  EXPECT_EQ(parts_of({turned(sphere(.7)), sphere(1)}), (Parts{0, 0}));
  EXPECT_EQ(parts_of({turned(sphere(1)), sphere(.7)}), (Parts{0, 0})) << "all of it turned inside out";
  EXPECT_EQ(parts_of({sphere(1), turned(sphere(.3, {.5, 0, 0})), turned(sphere(.3, {-.5, 0, 0}))}), (Parts{0, 0, 0}));
}

TEST(Voids, AreOfTheNearestShellAndWhatIsInThemIsASolid) {
  EXPECT_EQ(parts_of({sphere(1), turned(sphere(.8)), sphere(.6), turned(sphere(.4)), sphere(.2)}),
            (Parts{0, 0, 1, 1, 2}));
}

TEST(Voids, AreNotWhatIsTurnedAlikeOrOutsideOrCrossesOrIsOpen) {
  EXPECT_EQ(parts_of({sphere(1), sphere(.7)}), (Parts{0, 1}));
  EXPECT_EQ(parts_of({sphere(1), turned(sphere(.7, {2, 0, 0}))}), (Parts{0, 1}));
  EXPECT_EQ(parts_of({sphere(1), turned(sphere(.2, {.7, .7, .7}))}), (Parts{0, 1})) << "in the box alone";
  EXPECT_EQ(parts_of({sphere(1), turned(sphere(.5, {.55, .55, 0}))}), (Parts{0, 1}));
  MeshData open = turned(sphere(.7));
  open.faces.pop_back();
  EXPECT_EQ(parts_of({sphere(1), open}), (Parts{0, 1}));
  const MeshData tube =
      transformed(open_cylinder(12, 4, Faces::kQuads), [](const Vector3& x) { return Vector3(.5 * x); });
  EXPECT_EQ(parts_of({sphere(1), turned(tube)}), (Parts{0, 1})) << "its openings cancel each other out";
}

TEST(Voids, AddNothingThatHasAnArea) {
  const MeshData mesh = in_model_space(join(sphere(1), turned(sphere(.7))));
  const arap::PolygonMesh joined = arap::join_voids(mesh.mesh());
  EXPECT_EQ(joined.positions(), mesh.positions());
  ASSERT_GT(joined.n_faces(), mesh.n_faces());
  for (int f = mesh.n_faces(); f < joined.n_faces(); ++f) EXPECT_EQ(joined.face(f)[1], joined.face(f)[2]);
}

}  // namespace
}  // namespace arap_test
