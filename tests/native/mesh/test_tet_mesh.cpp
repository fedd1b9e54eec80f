// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/tet_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/helpers.h"
#include "support/tet_arap.h"

namespace arap_test {
namespace {

using Tets = std::vector<TetMesh::Tet>;

/// A corner of a cube, and a vertex beside it.
Positions corner() {
  Positions positions(5, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0;
  return positions;
}

TEST(TetMesh, HasItsTetrahedraWithPositiveVolume) {
  const TetMesh mesh(corner(), {{0, 1, 2, 3}, {0, 2, 1, 3}, {1, 4, 2, 3}});
  EXPECT_EQ(mesh.n_vertices(), 5);
  EXPECT_EQ(mesh.n_tets(), 3);
  EXPECT_EQ(mesh.tets()[0], (TetMesh::Tet{0, 1, 2, 3}));
  EXPECT_EQ(mesh.tets()[1], (TetMesh::Tet{0, 2, 3, 1}));
  for (int t = 0; t < mesh.n_tets(); ++t) EXPECT_NEAR(tet_volume(mesh, t), 1. / 6, 1e-15);
}

TEST(TetMesh, KnowsItsPartsAndWhatIsLoose) {
  Positions positions(10, 3);
  positions << corner(), corner().array() + 5;
  const TetMesh mesh(positions, {{6, 7, 8, 9}, {0, 1, 2, 3}});
  EXPECT_EQ(mesh.part_of_vertex(), (std::vector<int>{0, 0, 0, 0, -1, -1, 1, 1, 1, 1}));
  EXPECT_EQ(mesh.n_parts(), 2);
  EXPECT_EQ(mesh.loose_vertices(), (std::vector<int>{4, 5}));
  EXPECT_DOUBLE_EQ(TetMesh(corner() * 2, {{0, 1, 2, 3}}).diagonal(), std::sqrt(12.));
  EXPECT_DOUBLE_EQ(TetMesh(corner(), {}).diagonal(), std::sqrt(3.));
}

TEST(TetMesh, KnowsHowManyPartsThereWouldBeWithoutSeams) {
  const TetMesh whole = tet_blocks(2, 1, 1);
  Positions apart(4 * whole.n_tets(), 3);
  std::vector<TetMesh::Tet> tets;
  for (int t = 0; t < whole.n_tets(); ++t) {
    for (int k = 0; k < 4; ++k) apart.row(4 * t + k) = whole.positions().row(whole.tets()[t][k]);
    tets.push_back({4 * t, 4 * t + 1, 4 * t + 2, 4 * t + 3});
  }
  const TetMesh torn(apart, tets);
  EXPECT_EQ(torn.n_parts(), whole.n_tets());
  EXPECT_EQ(torn.n_parts_joined(), 1);
  EXPECT_EQ(whole.n_parts_joined(), 1);
}

TEST(TetMesh, FlatIsAMatterOfShapeNotOfSize) {
  for (const double size : {1e-150, 1e-60, 1e-3, 1e60, 1e99})
    EXPECT_EQ(TetMesh(corner() * size, {{0, 1, 2, 3}}).n_tets(), 1) << size;
  // A needle, and a plate.
  for (const Vector3& scale : {Vector3(1, 1e-6, 1e-6), Vector3(1, 1, 1e-9)})
    EXPECT_EQ(TetMesh(corner() * scale.asDiagonal(), {{0, 1, 2, 3}}).n_tets(), 1);
}

TEST(TetMeshErrors, SayWhichAndWhatToDo) {
  const auto expect_refused = [](const Positions& positions, const Tets& tets,
                                 std::initializer_list<std::string_view> words) {
    expect_error<arap::InvalidInput>([&] { const TetMesh mesh(positions, tets); }, words);
  };
  const TetMesh::Tet good{0, 1, 2, 3};
  expect_refused(corner(), {good, {0, 1, 2, 5}}, {"tetrahedron 1", "names vertex 5", "0 to 4", "correct or remove"});
  expect_refused(corner(), {{-1, 1, 2, 3}}, {"tetrahedron 0", "names vertex -1", "correct or remove"});
  expect_refused(corner(), {good, good, {0, 3, 2, 3}}, {"tetrahedron 2", "vertex 3 twice", "four different"});
  expect_refused(corner(), {good, {0, 1, 2, 4}}, {"tetrahedron 1 (0, 1, 2, 4)", "no volume", "remove it"});
  expect_refused(Positions::Zero(4, 3), {good}, {"tetrahedron 0", "no volume"});
  expect_refused(Positions(0, 3), {}, {"rest_positions is empty", "at least one vertex"});
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e101}) {
    Positions positions = corner();
    positions(2, 1) = bad;
    expect_refused(positions, {good}, {"vertex 2", "finite", "repair or remove"});
  }
  // Nearly in a plane that no number meets exactly.
  const Matrix3 turn = rotation_about({1, 2, 3}, .7);
  expect_refused(corner() * turn, {{0, 1, 2, 4}}, {"no volume"});
}

}  // namespace
}  // namespace arap_test
