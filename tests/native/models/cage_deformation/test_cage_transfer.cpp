// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "arap/cage_transfer.h"
#include "arap/error.h"
#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InvalidInput;
using arap::transfer_cage;
using Row = Eigen::RowVector3d;

/// Of the same faces: stretched, bent and moved.
MeshData other_shape(const MeshData& mesh) {
  return transformed(mesh, [](const Vector3& x) {
    return Vector3(3 * x[0] + .3 * std::sin(x[1]) + 5, 2 * x[1] - 1, x[2] + .2 * x[0] * x[1]);
  });
}

Row mean(const Positions& p) { return p.colwise().mean(); }

TEST(CageTransfer, ToItselfItIsTheMotionItself) {
  for (const MeshData& mesh : all_cages()) {
    const Positions moved = 10 * mesh.positions() + Random(9).noise(mesh.n_vertices(), mesh.diagonal());
    EXPECT_LT(max_distance(transfer_cage(mesh.mesh(), moved, mesh.mesh()), moved), 1e-9 * mesh.diagonal()) << mesh.name;
  }
}

TEST(CageTransfer, TurnsAndGrowsAsTheSourceAboutItsOwnMiddle) {
  const RigidMotion motion = Random(4).rigid_motion(3, 5);
  for (const MeshData& mesh : all_cages()) {
    const MeshData target = other_shape(mesh);
    const Positions result = transfer_cage(mesh.mesh(), 2 * motion.apply(mesh.positions()), target.mesh());
    const Positions about_middle = target.positions().rowwise() - mean(target.positions());
    const Row shift = mean(2 * motion.apply(mesh.positions())) - mean(mesh.positions());
    const Positions expected =
        (2 * about_middle * motion.rotation.transpose()).rowwise() + (mean(target.positions()) + shift);
    EXPECT_LT(max_distance(result, expected), 1e-9 * target.diagonal()) << mesh.name;
  }
}

/// In the same place the rigid motion is the source's own.
TEST(CageTransfer, SeveralShellsGoAsOne) {
  const MeshData mesh = two_spheres(1);
  const RigidMotion motion = Random(4).rigid_motion(3, 5);
  MeshData target = transformed(mesh, [](const Vector3& x) { return Vector3(1.5 * x); });
  const Row shift = mean(mesh.positions()) - mean(target.positions());
  target = transformed(target, [&](const Vector3& x) { return Vector3(x + shift.transpose()); });
  EXPECT_LT(max_distance(transfer_cage(mesh.mesh(), motion.apply(mesh.positions()), target.mesh()),
                         motion.apply(target.positions())),
            1e-9 * target.diagonal());
}

/// As teeth and eyes in a head.
TEST(CageTransfer, AShellThatDidNotMoveStays) {
  const MeshData mesh = two_spheres(1);
  const MeshData target = other_shape(mesh);
  const arap::PolygonMesh source = mesh.mesh();
  const std::vector<int>& part = source.part_of_vertex();
  const RigidMotion motion = Random(4).rigid_motion(3, 5);
  for (const int mover : {0, 1}) {
    Positions moved = mesh.positions();
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (part[v] == mover) moved.row(v) = 2 * motion.apply(mesh.vertices[v]).transpose();
    const Positions result = transfer_cage(mesh.mesh(), moved, target.mesh());
    double furthest = 0;
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (part[v] != mover) furthest = std::max(furthest, (result.row(v) - target.vertices[v].transpose()).norm());
    EXPECT_LT(furthest, 1e-9 * target.diagonal());
  }
}

TEST(CageTransfer, LooseVerticesHaveNoSay) {
  const MeshData mesh = two_spheres(1);
  const Positions moved = 2 * Random(4).rigid_motion(3, 5).apply(mesh.positions());
  const MeshData target = other_shape(mesh);
  const auto with_loose = [](const MeshData& cage) {
    MeshData result = cage;
    result.add_vertex({1e3, -2e3, 5e2});
    return result;
  };
  Positions moved_with_loose(mesh.n_vertices() + 1, 3);
  moved_with_loose << moved, 7, 8, 9;
  const Positions result = transfer_cage(with_loose(mesh).mesh(), moved_with_loose, with_loose(target).mesh());
  EXPECT_LT(max_distance(result.topRows(mesh.n_vertices()), transfer_cage(mesh.mesh(), moved, target.mesh())), 1e-9);
}

TEST(CageTransfer, DoesNotHangOnTheTargetsPlace) {
  const MeshData mesh = bumpy_sphere(1);
  const Positions moved = mesh.positions() + Random(9).noise(mesh.n_vertices(), .2);
  const MeshData target = other_shape(mesh);
  const Row away(100, -20, 7);
  const MeshData there = transformed(target, [&](const Vector3& x) { return Vector3(x + away.transpose()); });
  EXPECT_LT(max_distance(transfer_cage(mesh.mesh(), moved, there.mesh()).rowwise() - away,
                         transfer_cage(mesh.mesh(), moved, target.mesh())),
            1e-9 * there.diagonal());
}

/// A bar twice as thick takes over a bend: its end turns nearly as much, although its sides would have to stretch twice
/// as much as those of the source for that, and it stays as thick.
TEST(CageTransfer, AThickBarBendsAsAThinOne) {
  const MeshData thin = box({12, 2, 2}, {6, 1, 1}, Faces::kQuads);
  const MeshData thick = transformed(thin, [](const Vector3& x) { return Vector3(x[0], 2 * x[1], 2 * x[2]); });
  constexpr double kAngle = 1.5;
  const double radius = 6 / kAngle;
  Positions moved = thin.positions();
  for (Eigen::Index v = 0; v < moved.rows(); ++v) {
    const double angle = moved(v, 0) / radius;
    moved.row(v) << (radius - moved(v, 2)) * std::sin(angle), moved(v, 1),
        radius - (radius - moved(v, 2)) * std::cos(angle);
  }
  const Positions result = transfer_cage(thin.mesh(), moved, thick.mesh());
  const auto cap = [&](double x) {
    std::vector<int> found;
    for (int v = 0; v < thin.n_vertices(); ++v)
      if (std::abs(thin.vertices[v][0] - x) < 1e-9) found.push_back(v);
    return found;
  };
  const auto turn = [&](double x) {
    return best_rigid_motion(rows(thick.positions(), cap(x)), rows(result, cap(x))).rotation;
  };
  const Matrix3 between = turn(3) * turn(-3).transpose();
  EXPECT_NEAR(Eigen::AngleAxisd(between).angle(), kAngle, .2);
  EXPECT_NEAR(std::abs(Eigen::AngleAxisd(between).axis()[1]), 1, 1e-6);
  for (const double x : {-3.0, 3.0}) EXPECT_LT(off_rigid(thick.positions(), result, cap(x)), .1);
  for (int k = -5; k <= 5; ++k) {
    const Positions at_rest = rows(thick.positions(), cap(.5 * k));
    const Positions now = rows(result, cap(.5 * k));
    EXPECT_NEAR((now.rowwise() - mean(now)).norm() / (at_rest.rowwise() - mean(at_rest)).norm(), 1, .1);
  }
}

TEST(CageTransfer, ATriangleWithoutAreaGoesWithTheWhole) {
  MeshData mesh = icosphere(1);
  mesh.vertices[mesh.faces[0][2]] = (mesh.vertices[mesh.faces[0][0]] + mesh.vertices[mesh.faces[0][1]]) / 2;
  const Positions moved = 2 * Random(4).rigid_motion(3, 5).apply(mesh.positions());
  EXPECT_LT(max_distance(transfer_cage(mesh.mesh(), moved, mesh.mesh()), moved), 1e-9);
  EXPECT_TRUE(transfer_cage(mesh.mesh(), moved, icosphere(1).mesh()).allFinite());
  EXPECT_TRUE(transfer_cage(icosphere(1).mesh(), moved, mesh.mesh()).allFinite());
}

TEST(CageTransfer, SaysWhatIsWrong) {
  const MeshData mesh = cube();
  const auto transfer = [](const MeshData& source, const MeshData& target) {
    static_cast<void>(transfer_cage(source.mesh(), source.positions(), target.mesh()));
  };
  expect_error<InvalidInput>(
      [&] {
        transfer(MeshData{"", mesh.vertices, {}}, mesh);
      },
      {"the source has no faces or no size; give it faces"});
  expect_error<InvalidInput>([&] { transfer(mesh, icosphere(0)); },
                             {"the target has 12 vertices and 20 faces, the source 8 and 6; give cages of the same"});
  MeshData turned = mesh;
  std::rotate(turned.faces[2].begin(), turned.faces[2].begin() + 1, turned.faces[2].end());
  expect_error<InvalidInput>([&] { transfer(mesh, turned); }, {"face 2 of the target has other vertices"});
  Positions moved = mesh.positions();
  moved(3, 1) = 1e200;
  expect_error<InvalidInput>([&] { static_cast<void>(transfer_cage(mesh.mesh(), moved, mesh.mesh())); },
                             {"moved_source: vertex 3"});
  expect_error<InvalidInput>([&] { static_cast<void>(transfer_cage(mesh.mesh(), moved.topRows(7), mesh.mesh())); },
                             {"moved_source has 7 rows, expected 8"});
}

}  // namespace
}  // namespace arap_test
