// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_sides.h"

#include <gtest/gtest.h>

#include <algorithm>
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

/// The same mesh many times, side by side.
struct Sheets {
  Sheets(int n, const MeshData& sheet) : n_vertices(sheet.n_vertices()) {
    for (int k = 0; k < n; ++k) {
      const int first = mesh.n_vertices();
      for (const Vector3& vertex : sheet.vertices) mesh.add_vertex(place(k) + vertex);
      for (std::vector<int> face : sheet.faces) {
        for (int& v : face) v += first;
        mesh.faces.push_back(std::move(face));
      }
    }
  }
  static Vector3 place(int k) { return {10. * k, 0, 0}; }
  [[nodiscard]] auto of(Positions& positions, int k) const {
    return positions.middleRows(Eigen::Index{k} * n_vertices, n_vertices);
  }

  int n_vertices;
  MeshData mesh{"sheets", {}, {}};
};

TEST(SurfaceSides, DistancesGrowWithAPartThatIsScaledButNotWithOneThatMayBend) {
  constexpr double kDistance = .03;
  constexpr std::array kScales = {1., 1., .8, .4, 3.};
  const MeshData sheet = grid(8, Faces::kQuads);
  const Sheets sheets(5, sheet);
  Positions posed = sheets.mesh.positions();
  Positions points(5, 3);
  for (int k = 0; k < 5; ++k) {
    sheets.of(posed, k) = (kScales[k] * sheet.positions()).rowwise() + Sheets::place(k).transpose();
    points.row(k) = (Sheets::place(k) + Vector3(.1, .2, kDistance)).transpose();
  }
  const Positions now = WrapDeformation(sheets.mesh.mesh(), points).deform(posed);
  const Eigen::VectorXd expected = kDistance * Eigen::VectorXd{{1, 1, 1, .4, 3}};
  EXPECT_LT((now.col(2) - expected).cwiseAbs().maxCoeff(), 1e-3 * kDistance);
}

TEST(SurfaceSides, ThinTrianglesKeepDistancesHoweverPartsMoveTogether) {
  constexpr double kDistance = .03;
  const MeshData sheet =
      transformed(grid(8, Faces::kQuads), [](const Vector3& p) { return Vector3(p.x(), p.y() / 200, p.z()); });
  const Sheets sheets(5, sheet);
  Positions posed = sheets.mesh.positions();
  Positions points(5, 3);
  for (int k = 0; k < 5; ++k) {
    sheets.of(posed, k) = sheet.positions().rowwise() + .4 * Sheets::place(k).transpose();
    points.row(k) = (Sheets::place(k) + Vector3(.1, .001, kDistance)).transpose();
  }
  const Positions now = WrapDeformation(sheets.mesh.mesh(), points).deform(posed);
  EXPECT_LT((now.col(2).array() - kDistance).abs().maxCoeff(), 1e-3 * kDistance);
}

TEST(SurfaceSides, DistancesDoNotJumpWhenAnotherPartBecomesMostOfTheSurface) {
  constexpr int kSteps = 100;
  constexpr double kDistance = .02;
  const MeshData mesh = limb();
  const double middle = mesh.positions().col(2).mean();
  const WrapDeformation wrap(mesh.mesh(), sleeve(mesh, kDistance));
  // What is above a height that sinks is 1.3 times as large.
  const auto deformed = [&](int step) {
    Positions posed = mesh.positions();
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const double above = posed(v, 2) - middle + 2. * step / kSteps - 1;
      const double share = std::clamp(above + .5, 0., 1.);
      posed.row(v) *= 1 + .3 * share * share * (3 - 2 * share);
    }
    return wrap.deform(posed);
  };
  double farthest = 0;
  Positions former = deformed(0);
  Positions here = deformed(1);
  for (int step = 2; step <= kSteps; ++step) {
    Positions next = deformed(step);
    farthest = std::max(farthest, (next - 2 * here + former).rowwise().norm().maxCoeff());
    former = std::exchange(here, std::move(next));
  }
  EXPECT_LT(farthest, .1 * kDistance);
}

TEST(SurfaceSides, TrianglesThatCollapseBringPointsNowhere) {
  constexpr double kDistance = .02;
  const MeshData mesh = limb();
  const WrapDeformation wrap(mesh.mesh(), sleeve(mesh, kDistance));
  const Positions& rest = mesh.positions();
  // The normal's growth is a root, so of a part of 10⁻⁷ it leaves more.
  constexpr double kLeft = .01;
  for (const double size : {0., 1e-12, 1e-5}) {
    const Positions posed = size * rest + (1 - size) * Vector3(.1, .2, .3).transpose().replicate(rest.rows(), 1);
    const Positions now = wrap.deform(posed);
    EXPECT_LT((now.rowwise() - Eigen::RowVector3d(.1, .2, .3)).rowwise().norm().maxCoeff(), kLeft) << size;
  }
  // Half of it, to a line.
  Positions posed = rest;
  const double middle = rest.col(2).mean();
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (posed(v, 2) > middle) posed.row(v) << 0, 0, posed(v, 2);
  const Positions now = wrap.deform(posed);
  for (Eigen::Index k = 0; k < now.rows(); ++k) EXPECT_LT(now.row(k).head<2>().norm(), .6) << k;
}

TEST(SurfaceSides, WhatIsOnAPartThatShrinksShrinksWithIt) {
  const MeshData mesh = limb();
  const Positions points = sleeve(mesh, .02);
  const Eigen::RowVector3d end(0, 0, mesh.positions().col(2).mean());
  for (const bool stay_outside : {false, true}) {
    WrapOptions options;
    options.stay_outside = stay_outside;
    const WrapDeformation wrap(mesh.mesh(), points, options);
    for (const double scale : {.1, .01, .005, .003, .001}) {
      Positions posed = mesh.positions();
      for (int v = 0; v < mesh.n_vertices(); ++v)
        if (posed(v, 2) > end.z()) posed.row(v) = end + scale * (posed.row(v) - end);
      const Positions now = wrap.deform(posed);
      for (Eigen::Index k = 0; k < points.rows(); ++k) {
        if (points(k, 2) < end.z() + 1) continue;
        EXPECT_LT((now.row(k) - end - scale * (points.row(k) - end)).norm(), 2e-3) << scale << " " << k;
      }
    }
  }
}

TEST(SurfaceSides, WhatIsInsideStaysInside) {
  const MeshData mesh = limb();
  const Positions posed = bent_limb(mesh, 90);
  const Positions points = sleeve(mesh, -.01);
  EXPECT_EQ(n_inside(mesh, posed, WrapDeformation(mesh.mesh(), points).deform(posed)), points.rows());
}

}  // namespace
}  // namespace arap_test
