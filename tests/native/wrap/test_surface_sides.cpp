// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_sides.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "arap/wrap_deformation.h"
#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::WrapDeformation;
using arap::WrapOptions;

/// A limb along z of radius .5 and length 6.
MeshData limb() {
  return transformed(triangulate(cylinder(32, 60)), [](const Vector3& p) { return Vector3(p.x(), p.y(), 3 * p.z()); });
}

/// Bent in the middle; both ends are held.
Positions bent_limb(const MeshData& mesh, double degrees) {
  const Matrix3 turn = rotation_about(Vector3::UnitY(), degrees * std::numbers::pi / 180);
  const double middle = mesh.positions().col(2).mean();
  Task task;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const Vector3 p = mesh.vertices[v] - middle * Vector3::UnitZ();
    if (std::abs(p.z()) < 2) continue;
    task.add(v, (p.z() > 0 ? turn * p : p) + middle * Vector3::UnitZ());
  }
  arap::SurfaceArap model(mesh.mesh());
  model.set_constraints(task.constraints);
  model.solve(task.targets, to_accuracy(1e-3));
  return model.positions();
}

Positions sleeve(const MeshData& mesh, double offset) {
  constexpr int kAround = 45;
  constexpr int kAlong = 80;
  constexpr int kPoints = kAround * kAlong;
  const double low = mesh.positions().col(2).minCoeff();
  Positions points(kPoints, 3);
  for (int k = 0; k < kPoints; ++k) {
    const double angle = 2 * std::numbers::pi * k / kAround;
    points.row(k) << (.5 + offset) * std::cos(angle), (.5 + offset) * std::sin(angle), low + .5 + 5. * k / kPoints;
  }
  return points;
}

int n_inside(const MeshData& mesh, const Positions& posed, const Positions& points) {
  MeshData moved = mesh;
  for (int v = 0; v < mesh.n_vertices(); ++v) moved.vertices[v] = posed.row(v).transpose();
  int inside = 0;
  for (Eigen::Index k = 0; k < points.rows(); ++k) inside += winding(moved, points.row(k).transpose()) > .5 ? 1 : 0;
  return inside;
}

TEST(SurfaceSides, ASleeveStaysOutsideOfABentLimb) {
  const MeshData mesh = limb();
  const Positions posed = bent_limb(mesh, 120);
  for (const double offset : {.003, .015, .05}) {
    const Positions points = sleeve(mesh, offset);
    EXPECT_EQ(n_inside(mesh, posed, WrapDeformation(mesh.mesh(), points).deform(posed)), 0) << offset;
    MeshData inside_out = mesh;
    for (std::vector<int>& face : inside_out.faces) std::swap(face[0], face[1]);
    EXPECT_EQ(n_inside(mesh, posed, WrapDeformation(inside_out.mesh(), points).deform(posed)), 0) << offset;
  }
  // What pushes is needed: the mesh is coarser than this sleeve is near.
  WrapOptions without;
  without.stay_outside = false;
  EXPECT_GT(n_inside(mesh, posed, WrapDeformation(mesh.mesh(), sleeve(mesh, .003), without).deform(posed)), 20);
}

TEST(SurfaceSides, WhatIsOnAPartThatStaysKeepsItsDistance) {
  const MeshData mesh = limb();
  const Positions points = sleeve(mesh, .003);
  const Positions now = WrapDeformation(mesh.mesh(), points).deform(bent_limb(mesh, 120));
  const double held = mesh.positions().col(2).mean() - 2.2;
  int n_held = 0;
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    if (points(k, 2) > held) continue;
    ++n_held;
    EXPECT_LT((now.row(k) - points.row(k)).norm(), 1e-5);
  }
  EXPECT_GT(n_held, 100);
}

TEST(SurfaceSides, DistancesGrowWithAPartThatIsScaledButNotWithOneThatMayBend) {
  constexpr double kDistance = .03;
  constexpr std::array kScales = {1., 1., .8, .4, 3.};
  const MeshData sheet = grid(8, Faces::kQuads);
  MeshData sheets{"sheets that grow", {}, {}};
  Positions posed(5 * sheet.n_vertices(), 3);
  Positions points(5, 3);
  for (int k = 0; k < 5; ++k) {
    const int first = sheets.n_vertices();
    const Vector3 place(10. * k, 0, 0);
    for (const Vector3& vertex : sheet.vertices) sheets.add_vertex(place + vertex);
    for (std::vector<int> face : sheet.faces) {
      for (int& v : face) v += first;
      sheets.faces.push_back(std::move(face));
    }
    posed.middleRows(first, sheet.n_vertices()) = (kScales[k] * sheet.positions()).rowwise() + place.transpose();
    points.row(k) = (place + Vector3(.1, .2, kDistance)).transpose();
  }
  const Positions now = WrapDeformation(sheets.mesh(), points).deform(posed);
  const Eigen::VectorXd expected = kDistance * Eigen::VectorXd{{1, 1, 1, .4, 3}};
  EXPECT_LT((now.col(2) - expected).cwiseAbs().maxCoeff(), 1e-3 * kDistance);
}

TEST(SurfaceSides, WhatIsInsideStaysInside) {
  const MeshData mesh = limb();
  const Positions posed = bent_limb(mesh, 90);
  const Positions points = sleeve(mesh, -.01);
  EXPECT_EQ(n_inside(mesh, posed, WrapDeformation(mesh.mesh(), points).deform(posed)), points.rows());
}

}  // namespace
}  // namespace arap_test
