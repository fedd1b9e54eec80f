// SPDX-License-Identifier: GPL-3.0-or-later
// Held vertices cut a surface: what is pulled on one side moves nothing on the other.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "arap/lattice_arap.h"
#include "arap/surface_arap.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::SurfaceArap;

/// A flat U of two legs, 1 wide, `n` cells a unit. The left one has x < 1.5.
MeshData u_sheet(int n, Faces faces) {
  const MeshData square = transformed(grid(3 * n, faces), [](const Vector3& p) -> Vector3 {
    return {3 * p[0] + 1.5, 3 * p[1] + 1.5, 0};
  });
  MeshData result{"u_sheet", {}, {}};
  for (const std::vector<int>& face : square.faces) {
    Vector3 centre = Vector3::Zero();
    for (const int v : face) centre += square.vertices[v] / static_cast<double>(face.size());
    if (centre[0] > 1 && centre[0] < 2 && centre[1] > 1) continue;
    std::vector<int>& copy = result.faces.emplace_back();
    for (const int v : face) copy.push_back(result.vertex_at(square.vertices[v]));
  }
  return result;
}

/// The band around x = 1.5 held, the end of the left leg pulled.
struct CutTask {
  Task task;
  std::vector<int> right;

  CutTask(const MeshData& mesh, double half_width) {
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const Vector3& p = mesh.vertices[v];
      if (std::abs(p[0] - 1.5) <= half_width + 1e-9)
        task.add(v, p);
      else if (p[0] > 1.5)
        right.push_back(v);
      else if (p[1] > 2.9)
        task.add(v, p + Vector3(-.5, .3, .8));
    }
  }
};

arap::Options wide_nodes() {
  arap::Options options;
  options.rigidity_radius = .06;
  return options;
}

TEST(CutSurface, WhatIsPulledOnOneSideMovesNothingOnTheOther) {
  for (const Faces faces : {Faces::kTriangles, Faces::kQuads})
    for (const double half_width : {1.0 / 6, 1.0 / 3}) {
      SCOPED_TRACE(testing::Message() << "half of the band: " << half_width);
      const MeshData mesh = u_sheet(6, faces);
      const CutTask cut(mesh, half_width);
      SurfaceArap solver(mesh.mesh(), wide_nodes());
      solver.set_constraints(cut.task.constraints);
      const Positions posed = solver.solve(cut.task.targets, to_accuracy(1e-9)).positions;
      EXPECT_LT(max_distance(rows(posed, cut.right), rows(mesh.positions(), cut.right)), 1e-9 * mesh.diagonal());
      EXPECT_GT(max_distance(posed, mesh.positions()), .2);
    }
}

TEST(CutSurface, ALineOfVerticesHeldWhereItIsMovesNothing) {
  const MeshData mesh = u_sheet(6, Faces::kQuads);
  Task ends;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (const Vector3& p = mesh.vertices[v]; p[1] > 2.9)
      ends.add(v, p[0] > 1.5 ? p : Vector3(p + Vector3(-.5, .3, .8)));
  SurfaceArap solver(mesh.mesh(), wide_nodes());
  solver.set_constraints(ends.constraints);
  const Positions posed = solver.solve(ends.targets, to_accuracy(1e-9)).positions;
  Task held = ends;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][0] - 1.5) < 1e-9) held.add(v, posed.row(v).transpose());
  solver.set_constraints(held.constraints);
  EXPECT_LT(max_distance(solver.solve(held.targets, to_accuracy(1e-9)).positions, posed), 1e-7);
}

TEST(CutSurface, SoDoesASheetBesideALattice) {
  const MeshData mesh = u_sheet(12, Faces::kQuads);
  const MeshData both =
      join(mesh, transformed(cube(), [](const Vector3& p) -> Vector3 { return p + Vector3(1.5, -2, 0); }));
  const CutTask cut(mesh, 1.0 / 12);
  arap::LatticeArap solver(both.mesh());
  ASSERT_FALSE(solver.sheets().empty());
  solver.set_constraints(cut.task.constraints);
  const Positions posed = solver.solve(cut.task.targets, to_accuracy(1e-9)).positions;
  EXPECT_LT(max_distance(rows(posed, cut.right), rows(both.positions(), cut.right)), 1e-7);
}

TEST(CutSurface, ARegionThatIsHeldCutsAndOneThatTurnsDoesNot) {
  const MeshData mesh = u_sheet(6, Faces::kQuads);
  CutTask cut(mesh, 1.0 / 6);
  arap::VertexProperties properties;
  properties.rigid_regions.assign(mesh.n_vertices(), -1);
  for (const int v : cut.task.constraints.vertices)
    if (mesh.vertices[v][1] < 2.9) properties.rigid_regions[v] = 0;
  SurfaceArap solver(mesh.mesh(), wide_nodes(), properties);
  solver.set_constraints(cut.task.constraints);
  const Positions rest = rows(mesh.positions(), cut.right);
  EXPECT_LT(max_distance(rows(solver.solve(cut.task.targets, to_accuracy(1e-9)).positions, cut.right), rest), 1e-8);

  Task turning;
  for (size_t k = 0; k < cut.task.constraints.vertices.size(); ++k) {
    const int v = cut.task.constraints.vertices[k];
    if (mesh.vertices[v][1] > 2.9 || turning.constraints.vertices.empty())
      turning.add(v, cut.task.targets.row(static_cast<Eigen::Index>(k)).transpose());
  }
  solver.set_constraints(turning.constraints);
  EXPECT_GT(max_distance(rows(solver.solve(turning.targets, to_accuracy(1e-9)).positions, cut.right), rest), .01);
}

TEST(CutSurface, EnergyIsThatOfTheSolveAndItsGradientItsSlope) {
  const MeshData mesh = u_sheet(4, Faces::kTriangles);
  const CutTask cut(mesh, 0.25);
  SurfaceArap solver(mesh.mesh(), wide_nodes());
  solver.set_constraints(cut.task.constraints);
  const arap::SolveResult result = solver.solve(cut.task.targets, to_accuracy(1e-10));
  EXPECT_NEAR(solver.energy(result.positions), result.energy_after, 1e-9 * result.energy_after);
  Positions gradient = solver.energy_gradient(result.positions);
  for (const int v : cut.task.constraints.vertices) gradient.row(v).setZero();
  EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-6);

  Random random(3);
  const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), .1);
  const auto energy = [&](const Positions& x) { return solver.energy(x); };
  EXPECT_LT(max_distance(solver.energy_gradient(p), differences(energy, p, 1e-5)), 1e-6);
}

TEST(CutSurface, EnergyIsZeroForRigidMotionsAndNeverBelow) {
  const MeshData mesh = u_sheet(4, Faces::kQuads);
  const CutTask cut(mesh, 0.25);
  SurfaceArap solver(mesh.mesh(), wide_nodes());
  solver.set_constraints(cut.task.constraints);
  Random random(5);
  EXPECT_NEAR(solver.energy(random.rigid_motion(2, 3).apply(mesh.positions())), 0, 1e-9);
  SurfaceArap uncut(mesh.mesh(), wide_nodes());
  for (const double size : {.01, .1, 1.0, 10.0}) {
    const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), size);
    const double energy = solver.energy(p);
    EXPECT_GT(energy, 0);
    EXPECT_LE(energy, uncut.energy(p));  // the same terms, with more rotations to choose
    EXPECT_GT(energy, .5 * uncut.energy(p));
  }
}

TEST(CutSurface, ItsCellsGoWithTheConstraintsThatCutIt) {
  const MeshData mesh = u_sheet(6, Faces::kQuads);
  const CutTask cut(mesh, 1.0 / 6);
  Task other;
  for (size_t k = 0; k < cut.task.constraints.vertices.size(); ++k)
    if (k % 7 == 0)
      other.add(cut.task.constraints.vertices[k], cut.task.targets.row(static_cast<Eigen::Index>(k)).transpose());
  SurfaceArap fresh(mesh.mesh(), wide_nodes());
  fresh.set_constraints(other.constraints);
  const Positions expected = fresh.solve(other.targets, to_accuracy(1e-7)).positions;

  SurfaceArap solver(mesh.mesh(), wide_nodes());
  solver.set_constraints(cut.task.constraints);
  solver.solve(cut.task.targets, to_accuracy(1e-7));
  const arap::SolveResult again = solver.solve(cut.task.targets, to_accuracy(1e-7));
  EXPECT_EQ(again.iterations, 1);
  // From one set to the other nothing jumps.
  solver.set_constraints(other.constraints);
  EXPECT_EQ(solver.positions(), again.positions);
  solver.reset();
  EXPECT_EQ(solver.solve(other.targets, to_accuracy(1e-7)).positions, expected);
}

TEST(CutSurface, ManySmallPartsFollowWhatHoldsThem) {
  const MeshData mesh = u_sheet(8, Faces::kTriangles);
  Random random(7);
  const RigidMotion motion = random.rigid_motion(1, .5);
  Task task;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (random.uniform(0, 1) < .7) task.add(v, motion.apply(mesh.vertices[v]));
  SurfaceArap solver(mesh.mesh(), wide_nodes());
  solver.set_constraints(task.constraints);
  const Positions posed = solver.solve(task.targets, to_accuracy(1e-9)).positions;
  EXPECT_LT(max_distance(posed, motion.apply(mesh.positions())), 1e-7);
}

}  // namespace
}  // namespace arap_test
