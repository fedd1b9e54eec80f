// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "base/union_find.h"
#include "lattice/voids.h"
#include "parallel/meter.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::Lattice;
using arap::Workers;

double inside_volume(const Lattice& lattice) {
  double volume = 0;
  for (int piece = 0; piece < lattice.n_pieces(); ++piece) volume += lattice.pieces().inside(piece);
  return volume * std::pow(lattice.cube_size(), 3);
}

Positions embedded(const Lattice& lattice, const MeshData& mesh, const Positions& control_points) {
  Positions points = Positions::Zero(mesh.n_vertices(), 3);
  lattice.embed(control_points, Workers(2), points);
  return points;
}

/// Sets of control points that pieces hang together by.
int n_components(const Lattice& lattice) {
  arap::UnionFind sets(lattice.n_control_points());
  for (int piece = 0; piece < lattice.n_pieces(); ++piece)
    for (const int c : lattice.control_points(piece)) sets.join(c, lattice.control_points(piece)[0]);
  std::set<int> roots;
  for (int c = 0; c < lattice.n_control_points(); ++c) roots.insert(sets.find(c));
  return static_cast<int>(roots.size());
}

MeshData inside_out(MeshData mesh) {
  for (std::vector<int>& face : mesh.faces) std::reverse(face.begin(), face.end());
  return mesh;
}

TEST(Lattices, HangTogetherAsThePartsOfTheMeshDo) {
  for (const MeshData& mesh : all_small_meshes())
    for (const double size : {0.07, 0.31}) {
      const Lattice lattice(mesh.mesh(), size * mesh.diagonal());
      EXPECT_EQ(n_components(lattice), mesh.mesh().n_parts()) << mesh.name << " " << size;
    }
}

/// A ball of radius 1 with voids of one radius, in model space.
arap::PolygonMesh hollow_ball(int detail, double radius, const std::vector<Vector3>& centers) {
  MeshData mesh = icosphere(3);
  const MeshData unit = inside_out(icosphere(detail));
  for (const Vector3& center : centers)
    mesh = join(mesh, transformed(unit, [&](const Vector3& x) { return Vector3(radius * x + center); }));
  return arap::join_voids(in_model_space(mesh).mesh());
}

/// A void takes something away from a ball, and hangs on what is between it and the shell: in one piece with it in each
/// cube but a few that it cuts in two, however small it is.
TEST(Lattices, OfVoidsHaveHardlyMoreControlPoints) {
  std::vector<Vector3> specks;
  Random random(3);
  for (int k = 0; k < 10; ++k) {
    const double height = .2 * k - .9;
    const double side = .6 * std::sqrt(1 - height * height);
    specks.emplace_back(side * std::cos(2.4 * k), side * std::sin(2.4 * k), .6 * height);
  }
  for (const double size : {.04, .09}) {
    const Lattice solid(hollow_ball(0, 0, {}), size);
    const auto expect_few = [&](const arap::PolygonMesh& mesh, const std::string& what) {
      const Lattice lattice(mesh, size);
      EXPECT_EQ(mesh.n_parts(), 1) << what;
      EXPECT_EQ(n_components(lattice), 1) << what << ", cubes of " << size;
      EXPECT_LE(lattice.n_control_points(), 1.02 * solid.n_control_points()) << what << ", cubes of " << size;
    };
    for (const double radius : {.1, .5, .8})
      expect_few(hollow_ball(2, radius, {Vector3(.02, .03, .01)}), "a void of " + std::to_string(radius));
    for (const double radius : {1e-6, .003, .02, .06})
      expect_few(hollow_ball(1, radius, specks), "specks of " + std::to_string(radius));
  }
}

/// The cubes of a wall are one piece, however thin it is and however far apart the vertices of the shell are.
TEST(Lattices, HoldWallsBetweenAShellAndAVoidTogether) {
  const auto cube = [](int cells) { return box({cells, cells, cells}, {1, 1, 1}, Faces::kQuads); };
  const MeshData shell = cube(1);
  for (const double share : {.9, .97, .999, .999999}) {
    const MeshData inner = transformed(inside_out(cube(9)), [&](const Vector3& x) { return Vector3(share * x); });
    const Lattice hollow(arap::join_voids(in_model_space(join(shell, inner)).mesh()), .0713);
    const Lattice solid(in_model_space(shell).mesh(), .0713);
    EXPECT_EQ(n_components(hollow), 1) << share;
    EXPECT_LE(hollow.n_control_points(), solid.n_control_points()) << share;
  }
}

TEST(Lattices, EmbedAffineMapsExactly) {
  Random random(5);
  Matrix3 map;
  for (int k = 0; k < 3; ++k) map.col(k) = random.vector(1);
  for (const MeshData& mesh : all_small_meshes()) {
    Lattice lattice(mesh.mesh(), 0.13 * mesh.diagonal());
    const Positions moved = (lattice.rest() * map).rowwise() + Eigen::RowVector3d(1, 2, 3);
    const Positions expected = (mesh.positions() * map).rowwise() + Eigen::RowVector3d(1, 2, 3);
    const Positions points = embedded(lattice, mesh, moved);
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      if (lattice.piece_of_vertex()[v] < 0) continue;
      EXPECT_LT((points.row(v) - expected.row(v)).norm(), 1e-6 * mesh.diagonal()) << mesh.name;
    }
  }
}

TEST(Lattices, AreSmoothFromCubeToCube) {
  // Points on a line through several cubes: second differences of a C1 curve fall with the square of the step.
  MeshData mesh = grid(200, Faces::kTriangles);
  const Lattice lattice(mesh.mesh(), 0.21);
  Random random(6);
  const Positions points = embedded(lattice, mesh, random.noise(lattice.n_control_points(), 1));
  double roughest = 0;
  for (int i = 1; i < 200; ++i)
    roughest = std::max(roughest, (points.row(i - 1) - 2 * points.row(i) + points.row(i + 1)).norm());
  EXPECT_LT(roughest, 8 * std::pow(0.005 / 0.21, 2));
}

TEST(Lattices, FillWhatIsInside) {
  for (const MeshData& mesh : {cylinder(40, 20), inside_out(cylinder(40, 20))})
    EXPECT_NEAR(inside_volume(Lattice(mesh.mesh(), 0.1)), 3.14159 / 4 * 2, 0.02);
  EXPECT_NEAR(inside_volume(Lattice(open_cylinder(40, 20, Faces::kQuads).mesh(), 0.1)), 3.14159 / 4 * 2, 0.02);
  EXPECT_NEAR(inside_volume(Lattice(icosphere(3).mesh(), 0.15)), 4.0 / 3 * 3.14159, 0.1);
}

TEST(Lattices, FillHalfAShapeThatIsOpenAtItsMirrorPlane) {
  MeshData half = box({5, 10, 20}, {.5, 1, 2}, Faces::kQuads);
  const auto is_in_plane = [&](int v) { return half.vertices[v][0] < -.25 + 1e-9; };
  std::erase_if(half.faces,
                [&](const std::vector<int>& face) { return std::all_of(face.begin(), face.end(), is_in_plane); });
  EXPECT_NEAR(inside_volume(Lattice(half.mesh(), 0.1)), 1, 0.02);
}

TEST(Lattices, OfASheetHaveNoInside) {
  EXPECT_EQ(inside_volume(Lattice(grid(9, Faces::kQuads).mesh(), 0.13)), 0);
  // Also if rays pass through it several times: three walls of a corner, twice.
  const MeshData corner = box({6, 6, 6}, {1, 1, 1}, Faces::kQuads);
  MeshData walls{"walls", corner.vertices, {}};
  for (const std::vector<int>& face : corner.faces)
    for (int axis = 0; axis < 3; ++axis)
      if (std::all_of(face.begin(), face.end(), [&](int v) { return corner.vertices[v][axis] < -.49; }))
        walls.faces.insert(walls.faces.end(), 2, face);
  EXPECT_EQ(inside_volume(Lattice(walls.mesh(), 0.13)), 0);
}

/// Bowls on both sides, one bowl in a wide plane, and a fold.
TEST(Lattices, OfAWavySheetHaveNoInside) {
  const auto waves = [](double x, double y) { return .2 * std::sin(20 * x) * std::sin(20 * y); };
  const auto hill = [](double x, double y) { return .3 * std::exp(-50 * (x * x + y * y)); };
  const auto folds = [](double x, double /*y*/) { return .3 * std::sin(15 * x); };
  for (const auto& height : std::initializer_list<std::function<double(double, double)>>{waves, hill, folds})
    for (const MeshData& mesh : {grid(60, Faces::kQuads, height), inside_out(grid(60, Faces::kQuads, height))})
      EXPECT_EQ(inside_volume(Lattice(mesh.mesh(), 0.04)), 0);
}

/// From whatever corner, a face is nowhere but where it is.
TEST(Lattices, OfAConcaveFaceAreNotInItsBay) {
  const std::vector<Vector3> corners = {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0},
                                        {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  for (int first = 0; first < 8; ++first) {
    MeshData mesh{"bay", corners, {{}}};
    for (int k = 0; k < 8; ++k) mesh.faces[0].push_back((first + k) % 8);
    const Lattice lattice(mesh.mesh(), 0.1);
    for (int piece = 0; piece < lattice.n_pieces(); ++piece) {
      const Eigen::RowVector3d middle = lattice.rest().row(lattice.control_points(piece)[13]);
      EXPECT_FALSE(std::abs(middle[0] - 1.5) < .4 && middle[1] > 1.1) << "from corner " << first;
    }
  }
}

TEST(Lattices, OfSmallPartsHaveACubeEach) {
  MeshData mesh{"dust", {}, {}};
  Random random(3);
  constexpr int kParts = 50;
  for (int k = 0; k < kParts; ++k) {
    const Vector3 place = random.vector(1);
    mesh = join(mesh, transformed(cube(), [&](const Vector3& x) { return Vector3(place + .04 * x); }));
  }
  const Lattice lattice(mesh.mesh(), 0.05);
  EXPECT_EQ(lattice.n_pieces(), kParts);
  EXPECT_EQ(lattice.n_control_points(), kParts * arap::kControlPoints);
}

TEST(Lattices, SayHowFarTheyAreWithinAPart) {
  double told = 0;
  int n_told = 0;
  const arap::Progress progress = [&](double done) {
    EXPECT_GE(done, told);
    told = done;
    ++n_told;
    return true;
  };
  arap::Meter meter(progress, "");
  const Lattice lattice(join(icosphere(3), cube()).mesh(), 0.1, {&meter, .5});
  meter.tell();
  EXPECT_NEAR(told, .5, 1e-9);
}

TEST(Lattices, SeparateFingersInOneCube) {
  const MeshData mesh = hand(0.05);
  ASSERT_EQ(mesh.mesh().n_parts(), 1);
  const Lattice lattice(mesh.mesh(), 0.2);
  EXPECT_EQ(n_components(lattice), 1);
  std::map<int, std::set<bool>> sides;  // of the vertices that each control point moves, above the palm
  const Positions points = mesh.positions();
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (points(v, 2) > 0)
      for (const int c : lattice.control_points(lattice.piece_of_vertex()[v])) sides[c].insert(points(v, 0) > 0);
  for (const auto& [c, of_point] : sides) EXPECT_EQ(of_point.size(), 1) << "control point " << c << " moves both";
}

TEST(Lattices, OfPartsThatOverlapAreApart) {
  const MeshData ball = icosphere(2);
  const MeshData mesh = join(ball, transformed(ball, [](const Vector3& x) { return Vector3(x + Vector3(1, 0, 0)); }));
  const Lattice lattice(mesh.mesh(), 0.3);
  EXPECT_EQ(n_components(lattice), 2);
  for (int piece = 0; piece < lattice.n_pieces(); ++piece)
    for (const int c : lattice.control_points(piece))
      EXPECT_EQ(lattice.part_of_control_point()[c], lattice.part_of_control_point()[lattice.control_points(piece)[0]]);
}

TEST(Lattices, OfAMirroredShapeAreMirrored) {
  const MeshData mesh = quad_sphere(12);
  const Lattice lattice(mesh.mesh(), 0.17 * mesh.diagonal());
  std::multiset<std::array<long, 3>> points;
  std::multiset<std::array<long, 3>> images;
  const double middle = (mesh.positions().col(0).maxCoeff() + mesh.positions().col(0).minCoeff()) / 2;
  for (int c = 0; c < lattice.n_control_points(); ++c) {
    const Eigen::RowVector3d p = lattice.rest().row(c) * 1e6;
    points.insert({std::lround(p[0] - 1e6 * middle), std::lround(p[1]), std::lround(p[2])});
    images.insert({std::lround(1e6 * middle - p[0]), std::lround(p[1]), std::lround(p[2])});
  }
  EXPECT_EQ(points, images);
}

/// The share of cubes that have several pieces.
double doubled_cubes(const Lattice& lattice) {
  std::map<std::array<long, 3>, int> n_pieces;
  for (int piece = 0; piece < lattice.n_pieces(); ++piece) {
    const Eigen::RowVector3d middle = lattice.rest().row(lattice.control_points(piece)[13]) * 1e6;
    ++n_pieces[{std::lround(middle[0]), std::lround(middle[1]), std::lround(middle[2])}];
  }
  const auto n_doubled = std::count_if(n_pieces.begin(), n_pieces.end(), [](const auto& at) { return at.second > 1; });
  return static_cast<double>(n_doubled) / static_cast<double>(n_pieces.size());
}

TEST(Lattices, HaveAboutAsManyPiecesAsCubes) {
  // Where a smooth surface passes, no cube has two.
  EXPECT_LE(doubled_cubes(Lattice(icosphere(4).mesh(), 0.12)), 0.01);
}

TEST(Lattices, HaveAsManyPiecesAsCubesIfVerticesAreOnTheirWalls) {
  for (const int n_around : {24, 48})
    for (const double size : {.25, .3}) {
      const MeshData rod =
          transformed(cylinder(n_around, 3 * n_around), [](const Vector3& x) { return Vector3(x[0], x[1], 3 * x[2]); });
      EXPECT_EQ(doubled_cubes(Lattice(rod.mesh(), size)), 0) << n_around << " " << size;
    }
  // Its faces lie in walls.
  EXPECT_LT(doubled_cubes(Lattice(box({20, 20, 20}, {1, 1, 1}, Faces::kQuads).mesh(), .2)), .05);
}

TEST(CubeSize, DependsOnTheThicknessNotOnTheNumberOfVertices) {
  const auto size_of = [](const MeshData& mesh) {
    const MeshData unit = in_unit_size(mesh);
    return arap::choose_cube_size(unit.mesh(), 0, 1);
  };
  const auto rod = [](int n_around) {
    return transformed(cylinder(n_around, 40), [](const Vector3& x) { return Vector3(.1 * x[0], .1 * x[1], x[2]); });
  };
  EXPECT_NEAR(size_of(rod(60)), .1 / 2 / 4, .002);
  EXPECT_NEAR(size_of(rod(120)), size_of(rod(60)), .0005);
  EXPECT_NEAR(size_of(icosphere(3)), .02, 1e-5);
}

/// A large sheet beside a rod has no limbs.
TEST(CubeSize, IsThatOfWhatHasAnInside) {
  const MeshData rod =
      transformed(cylinder(24, 40), [](const Vector3& x) { return Vector3(.1 * x[0], .1 * x[1], x[2]); });
  const MeshData ground =
      transformed(grid(20, Faces::kQuads), [](const Vector3& x) { return Vector3(4 * x[0], 4 * x[1], -1.5); });
  const MeshData both = join(rod, ground);
  const auto size_of = [](const MeshData& mesh) {
    return mesh.diagonal() * arap::choose_cube_size(in_unit_size(mesh).mesh(), 0, 1);
  };
  EXPECT_NEAR(size_of(both), size_of(rod), .1 * size_of(rod));
}

/// The box around it has a million times as many cubes.
TEST(CubeSize, OfAThinDiagonalRodIsFine) {
  const Matrix3 turn = rotation_about(Vector3(1, -1, 0), .955);
  const MeshData rod = in_unit_size(transformed(
      cylinder(12, 200), [&](const Vector3& x) { return Vector3(turn * Vector3(.016 * x[0], .016 * x[1], x[2])); }));
  const double size = arap::choose_cube_size(rod.mesh(), 0, 1);
  EXPECT_NEAR(size, .016 / 2 / 4, 2e-4);
  const Lattice lattice(rod.mesh(), size);
  EXPECT_LT(lattice.n_pieces(), 40 / size);
  EXPECT_NEAR(inside_volume(lattice), 3.14159 / 4 * .008 * .008, 5e-6);
}

/// Hairs far thinner than a cube: neither area nor volume tell how many they cross.
TEST(CubeSize, BoundsTheCubesOfThinParts) {
  MeshData hairs{"hairs", {}, {}};
  Random random(8);
  constexpr int kHairs = 2000;
  for (int k = 0; k < kHairs; ++k) {
    const int a = hairs.add_vertex(random.vector(1));
    const int b = hairs.add_vertex(random.vector(1));
    const int c = hairs.add_vertex(hairs.vertices[b] + random.vector(1e-4));
    hairs.faces.push_back({a, b, c});
  }
  const MeshData mesh = in_unit_size(hairs);
  // Those that are many cubes long are surfaces, see Lattice.
  EXPECT_LE(Lattice(mesh.mesh(), arap::choose_cube_size(mesh.mesh(), 0, 1), {}, 8).n_pieces(), 26000);
}

}  // namespace
}  // namespace arap_test
