// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "arap/cage.h"
#include "arap/error.h"
#include "cages/cage.h"
#include "cages/green.h"
#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::make_cage;
using Row = Eigen::RowVector3d;

/// Every edge has two faces, and the faces at each vertex are one fan.
void expect_manifold(const arap::PolygonMesh& mesh, const std::string& name) {
  std::map<std::pair<int, int>, int> edges;
  std::map<int, std::map<int, int>> next_around;  // of each vertex: from the neighbour before to the one after
  for (int f = 0; f < mesh.n_faces(); ++f)
    for (int k = 0; k < 4; ++k) {
      const auto corner = [&](int at) { return mesh.face(f)[at % 4]; };
      ++edges[std::minmax({corner(k), corner(k + 1)})];
      next_around[corner(k)][corner(k + 3)] = corner(k + 1);
    }
  for (const auto& [edge, n] : edges) EXPECT_EQ(n, 2) << name;
  for (const auto& [vertex, next] : next_around) {
    std::set<int> fan;
    for (int at = next.begin()->first; fan.insert(at).second;) at = next.at(at);
    EXPECT_EQ(fan.size(), next.size()) << name << ", vertex " << vertex;
  }
}

TEST(AutomaticCage, IsAManifoldAroundTheMesh) {
  for (const MeshData& mesh : all_small_meshes()) {
    if (mesh.mesh().diagonal() == 0) continue;
    for (const int cells : {4, 10}) {
      const arap::PolygonMesh quads = make_cage(mesh.mesh(), cells);
      expect_manifold(quads, mesh.name);
      const arap::Cage cage(quads);
      for (const Vector3& vertex : mesh.vertices)
        EXPECT_NEAR(winding_number(cage, cage.to_cage(vertex.transpose())), 1, 1e-9) << mesh.name;
    }
  }
}

/// Cubes touch at edges where a sheet rises by as much as it is long; what joins them must not fill the room around it.
TEST(AutomaticCage, OfAThinWavySheetIsThin) {
  const MeshData sheet =
      grid(19, Faces::kQuads, [](double x, double y) { return .016 * std::sin(38 * x) * std::cos(32 * y); });
  for (const int cells : {8, 10, 16, 25}) {
    const arap::PolygonMesh cage = make_cage(sheet.mesh(), cells);
    expect_manifold(cage, sheet.name);
    EXPECT_LT(cage.positions().col(2).maxCoeff(), .016 + 2.0 / cells) << cells;
  }
}

TEST(AutomaticCage, CarriesTheMesh) {
  const MeshData mesh = bumpy_sphere(3);
  const arap::PolygonMesh cage = make_cage(mesh.mesh());
  arap::CageOptions options;
  options.coordinates = arap::CageCoordinates::kGreen;
  const arap::CageDeformation green(cage, mesh.positions(), options);
  EXPECT_LT(max_distance(green.deform(2 * cage.positions()), 2 * mesh.positions()), 1e-12);
}

/// As from a coarse one: a seventh of a cube.
TEST(AutomaticCage, KeepsItsDistanceFromADenseMesh) {
  constexpr int kCells = 4;
  const arap::PolygonMesh cage = make_cage(icosphere(6).mesh(), kCells);
  double nearest = 1e300;
  for (int f = 0; f < cage.n_faces(); ++f) {
    const auto corner = [&](int k) { return Row(cage.positions().row(cage.face(f)[k])); };
    for (double a = 0; a <= 1; a += .125)
      for (double b = 0; b <= 1; b += .125)
        nearest = std::min(
            nearest,
            ((1 - b) * ((1 - a) * corner(0) + a * corner(1)) + b * ((1 - a) * corner(3) + a * corner(2))).norm());
  }
  EXPECT_GT(nearest, 1 + 2.0 / kCells / 7);
  EXPECT_LT(nearest, 1 + 2.0 / kCells);
}

TEST(AutomaticCage, FollowsTheMeshAndTheNumberOfCells) {
  const MeshData mesh = bar(2, Faces::kQuads);
  const arap::PolygonMesh coarse = make_cage(mesh.mesh(), 4);
  const arap::PolygonMesh fine = make_cage(mesh.mesh(), 12);
  EXPECT_LT(coarse.n_vertices(), fine.n_vertices() / 3);
  EXPECT_LT(fine.diagonal(), coarse.diagonal());
  EXPECT_LT(fine.diagonal(), 1.4 * mesh.diagonal());
}

TEST(AutomaticCage, OfAnySizeIsTheSame) {
  const MeshData mesh = bumpy_sphere(2);
  const Positions expected = make_cage(mesh.mesh(), 5).positions();
  for (const double size : {1e99, 1e-99, 1e-150}) {
    const MeshData scaled = transformed(mesh, [&](const Vector3& x) { return Vector3(size * x); });
    const Positions cage = make_cage(scaled.mesh(), 5).positions() / size;
    ASSERT_EQ(cage.rows(), expected.rows());
    EXPECT_LT(max_distance(cage, expected), 1e-12);
  }
}

/// Two spheres apart have a cage each, with one surface.
TEST(AutomaticCage, PartsFarApartAreParts) {
  const MeshData ball = icosphere(2);
  const MeshData two = join(ball, transformed(ball, [](const Vector3& x) { return Vector3(x + Vector3(9, 0, 0)); }));
  EXPECT_EQ(make_cage(two.mesh(), 20).n_parts(), 2);
  EXPECT_EQ(make_cage(two.mesh(), 2).n_parts(), 1);
}

TEST(AutomaticCage, ProgressRisesToOneAndMayStop) {
  const MeshData mesh = bar(2, Faces::kQuads);
  std::vector<double> told;
  static_cast<void>(make_cage(mesh.mesh(), 4, [&](double fraction) {
    told.push_back(fraction);
    return true;
  }));
  ASSERT_FALSE(told.empty());
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1);
  expect_error<arap::Cancelled>([&] { static_cast<void>(make_cage(mesh.mesh(), 4, [](double) { return false; })); },
                                {"the cage", "cancelled"});
}

TEST(AutomaticCageErrors, SayWhatIsWrong) {
  using arap::InvalidInput;
  const auto make = [](const MeshData& mesh, int cells) {
    return [mesh, cells] { static_cast<void>(make_cage(mesh.mesh(), cells)); };
  };
  expect_error<InvalidInput>(make(cube(), 1), {"cells = 1", "2", "50"});
  expect_error<InvalidInput>(make(cube(), 51), {"cells = 51"});
  expect_error<InvalidInput>(make({"points", {{0, 0, 0}, {1, 1, 1}}, {}}, 10), {"no faces", "give it faces"});
}

}  // namespace
}  // namespace arap_test
