// SPDX-License-Identifier: GPL-3.0-or-later
// Parts without an inside, beside others that have one.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "arap/error.h"
#include "arap/lattice_arap.h"
#include "arap/surface_arap.h"
#include "models/lattice_arap/rods.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::LatticeArap;
using arap::SolveResult;
using arap::StopReason;

/// A rod, and a cloth beside it: part 1.
struct Dressed {
  MeshData body = rod(12, 36);
  MeshData cloth =
      transformed(grid(12, Faces::kQuads), [](const Vector3& x) { return Vector3(2 * x[0] + 2, 0, 2 * x[1]); });
  MeshData mesh = join(body, cloth);

  /// The rod's ends held and bent, the cloth's rows z = -1 and z = 1 held and bent.
  [[nodiscard]] Task task(bool of_body = true, bool of_cloth = true) const {
    Task task;
    const RigidMotion bend{rotation_about(Vector3(1, 0, 0), .7), Vector3(0, .1, .5)};  // so that no cloth buckles
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const Vector3& x = mesh.vertices[v];
      const bool is_body = v < body.n_vertices();
      if (is_body ? !of_body || std::abs(x[2]) < 2.6 : !of_cloth || std::abs(x[2]) < .99) continue;
      task.add(v, x[2] > 0 ? bend.apply(x) : x);
    }
    return task;
  }
  /// The tops of both as one rigid region.
  [[nodiscard]] arap::VertexProperties rigid_tops() const {
    arap::VertexProperties properties;
    properties.rigid_regions.assign(mesh.n_vertices(), -1);
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (mesh.vertices[v][2] > (v < body.n_vertices() ? 2.4 : .6)) properties.rigid_regions[v] = 0;
    return properties;
  }
  [[nodiscard]] Positions of_body(const Positions& all) const { return all.topRows(body.n_vertices()); }
  [[nodiscard]] Positions of_cloth(const Positions& all) const { return all.bottomRows(cloth.n_vertices()); }
};

TEST(Sheets, ArePosedAsTheSurfaceThatTheyAre) {
  const Dressed dressed;
  const Task task = dressed.task();
  const SolveResult both = solve_once(dressed.mesh, task, coarse());
  EXPECT_EQ(both.stop_reason, StopReason::kConverged);
  Task alone;
  for (size_t k = 0; k < task.constraints.vertices.size(); ++k)
    if (const int v = task.constraints.vertices[k] - dressed.body.n_vertices(); v >= 0)
      alone.add(v, task.targets.row(static_cast<int>(k)).transpose());
  arap::Options options;
  options.rigidity_radius *= dressed.mesh.diagonal() / dressed.cloth.diagonal();
  const Positions expected = solve_once(dressed.cloth, alone, to_accuracy(1e-7), options).positions;
  EXPECT_LT(furthest(dressed.of_cloth(both.positions), expected), 1e-5 * dressed.mesh.diagonal());
  // The rod is what it is without the cloth, with cubes of the same size.
  arap::LatticeOptions of_rod = coarse();
  of_rod.cube_size *= dressed.mesh.diagonal() / dressed.body.diagonal();
  const Positions rod_alone = solve_once(dressed.body, dressed.task(true, false), of_rod).positions;
  EXPECT_LT(furthest(dressed.of_body(both.positions), rod_alone), 1e-5 * dressed.mesh.diagonal());
}

TEST(Sheets, StayAtRestWithoutConstraintsAndSoDoesTheBody) {
  const Dressed dressed;
  const SolveResult body = solve_once(dressed.mesh, dressed.task(true, false), coarse());
  EXPECT_EQ(body.parts_at_rest, std::vector<int>{1});
  EXPECT_EQ(LatticeArap(dressed.mesh.mesh(), coarse()).sheets(), std::vector<int>{1});
  EXPECT_LT(furthest(dressed.of_cloth(body.positions), dressed.cloth.positions()), 1e-12);
  const SolveResult cloth = solve_once(dressed.mesh, dressed.task(false, true), coarse());
  EXPECT_EQ(cloth.parts_at_rest, std::vector<int>{0});
  EXPECT_LT(furthest(dressed.of_body(cloth.positions), dressed.body.positions()), 1e-7);
  EXPECT_GT(furthest(dressed.of_cloth(cloth.positions), dressed.cloth.positions()), .1);
}

TEST(Sheets, GoBackToRestIfTheirConstraintsGo) {
  const Dressed dressed;
  LatticeArap solver(dressed.mesh.mesh(), coarse());
  const Task both = dressed.task();
  solver.set_constraints(both.constraints);
  solver.solve(both.targets);
  const Task body = dressed.task(true, false);
  solver.set_constraints(body.constraints);
  EXPECT_LT(furthest(dressed.of_cloth(solver.solve(body.targets).positions), dressed.cloth.positions()), 1e-12);
}

/// Whoever of both is at work when the solve is stopped.
TEST(Sheets, ACancelledSolveChangesNothing) {
  const Dressed dressed;
  const Task task = dressed.task();
  for (const double stop : {.0, .1, .5}) {
    LatticeArap solver(dressed.mesh.mesh(), coarse());
    solver.set_constraints(task.constraints);
    const SolveResult stopped =
        solver.solve(task.targets, to_accuracy(1e-9), {}, [&](double done) { return done < stop; });
    EXPECT_EQ(stopped.stop_reason, StopReason::kCancelled) << stop;
    EXPECT_EQ(stopped.positions, dressed.mesh.positions()) << stop;
    const Positions next = solver.solve(task.targets, to_accuracy(1e-6)).positions;
    EXPECT_LT(furthest(next, solve_once(dressed.mesh, task, coarse()).positions), 1e-4 * dressed.mesh.diagonal());
  }
}

TEST(Sheets, GoOnFromGivenPositionsAndBackToRest) {
  const Dressed dressed;
  const Task task = dressed.task();
  const Positions posed = solve_once(dressed.mesh, task, coarse()).positions;
  LatticeArap solver(dressed.mesh.mesh(), coarse());
  solver.set_constraints(task.constraints);
  solver.set_positions(posed);
  const Positions next = solver.solve(task.targets, iterations(1)).positions;
  EXPECT_LT(furthest(dressed.of_cloth(next), dressed.of_cloth(posed)), 1e-4 * dressed.mesh.diagonal());
  solver.reset();
  EXPECT_LT(furthest(solver.positions(), dressed.mesh.positions()), 1e-12);
}

TEST(Sheets, ARigidRegionMayJoinThemToABody) {
  const Dressed dressed;
  const arap::VertexProperties properties = dressed.rigid_tops();
  std::vector<int> region;
  for (int v = 0; v < dressed.mesh.n_vertices(); ++v)
    if (properties.rigid_regions[v] == 0) region.push_back(v);
  const Task task = dressed.task(true, false);
  LatticeArap solver(dressed.mesh.mesh(), coarse(), properties);
  solver.set_constraints(task.constraints);
  const Positions posed = solver.solve(task.targets).positions;
  const int a = region.front();
  for (const int b : region)
    EXPECT_NEAR((posed.row(a) - posed.row(b)).norm(), (dressed.mesh.vertices[a] - dressed.mesh.vertices[b]).norm(),
                1e-9);
}

/// As if the whole were one body, although the lattice does not know that parts belong together.
TEST(Sheets, APartWithoutConstraintsGoesWithItsRigidRegion) {
  const Dressed dressed;
  const Task held = hold(dressed.mesh, extreme_vertices(dressed.body.positions(), 2, .1));
  const RigidMotion motion = Random(5).rigid_motion(1, 3);
  const Task task = rigid_task(dressed.mesh, held.constraints, motion);
  LatticeArap solver(dressed.mesh.mesh(), coarse(), dressed.rigid_tops());
  solver.set_constraints(task.constraints);
  const SolveResult result = solver.solve(task.targets, to_accuracy(1e-7));
  EXPECT_TRUE(result.parts_at_rest.empty());
  for (int v = 0; v < dressed.mesh.n_vertices(); ++v)
    EXPECT_LT((result.positions.row(v).transpose() - motion.apply(dressed.mesh.vertices[v])).norm(), 1e-4);
}

/// Also one of another set of constraints, which the sheet would go back to rest for.
TEST(Sheets, ACancelledChangeOfConstraintsKeepsThePose) {
  const Dressed dressed;
  const Task task = dressed.task();
  LatticeArap solver(dressed.mesh.mesh(), coarse());
  solver.set_constraints(task.constraints);
  const Positions posed = solver.solve(task.targets, to_accuracy(1e-6)).positions;
  EXPECT_THROW(solver.set_constraints(dressed.task(true, false).constraints, [](double) { return false; }),
               arap::Cancelled);
  const Positions next = solver.solve(task.targets, iterations(1)).positions;
  EXPECT_LT(furthest(dressed.of_cloth(next), dressed.of_cloth(posed)), 1e-4 * dressed.mesh.diagonal());
}

TEST(Sheets, APatchMayHoldABodyAndAHardVertexOfASheet) {
  const Dressed dressed;
  const int n = dressed.body.n_vertices();
  Task task = hold(dressed.mesh, {0, n});
  task.add_patch({100, n}, {.5, .5}, (dressed.mesh.vertices[100] + dressed.mesh.vertices[n]) / 2);
  EXPECT_TRUE(solve_once(dressed.mesh, task, coarse()).positions.allFinite());
}

TEST(Sheets, TakePatches) {
  const Dressed dressed;
  const int n = dressed.body.n_vertices();
  Task task = dressed.task(true, false);
  task.add(n, dressed.mesh.vertices[n]);
  const Vector3 middle = (dressed.mesh.vertices[n + 80] + dressed.mesh.vertices[n + 81]) / 2;
  task.add_patch({n + 80, n + 81}, {.5, .5}, middle + Vector3(0, .3, 0));
  const SolveResult result = solve_once(dressed.mesh, task, coarse());
  EXPECT_TRUE(result.parts_at_rest.empty());
  const Vector3 reached = (result.positions.row(n + 80) + result.positions.row(n + 81)).transpose() / 2;
  EXPECT_LT((reached - middle - Vector3(0, .3, 0)).norm(), 1e-6);
}

TEST(Sheets, KeepTheirConstraintsIfAChangeIsCancelled) {
  const Dressed dressed;
  const Task task = dressed.task();
  LatticeArap solver(dressed.mesh.mesh(), coarse());
  solver.set_constraints(task.constraints);
  const Positions before = solver.solve(task.targets, to_accuracy(1e-6)).positions;
  for (int n_told = 0; n_told < 4; ++n_told) {
    int told = 0;
    const auto stop = [&](double) { return told++ < n_told; };
    try {
      solver.set_constraints(dressed.task(true, false).constraints, stop);
      solver.set_constraints(task.constraints);
    } catch (const arap::Cancelled&) {
    }
    EXPECT_LT(furthest(solver.solve(task.targets, to_accuracy(1e-6)).positions, before),
              1e-4 * dressed.mesh.diagonal());
  }
}

TEST(Sheets, AloneAreCarriedByCubes) {
  const MeshData cloth = grid(12, Faces::kQuads);
  const Task task = bend_task(cloth, default_bend(cloth));
  LatticeArap solver(cloth.mesh(), coarse());
  EXPECT_FALSE(solver.has_inside());
  EXPECT_TRUE(LatticeArap(rod(12, 12).mesh(), coarse()).has_inside());
  EXPECT_GT(solver.n_control_points(), 100);
  solver.set_constraints(task.constraints);
  const Positions posed = solver.solve(task.targets).positions;
  for (size_t k = 0; k < task.constraints.vertices.size(); ++k)
    EXPECT_LT((posed.row(task.constraints.vertices[k]) - task.targets.row(static_cast<int>(k))).norm(), 1e-12);
}

}  // namespace
}  // namespace arap_test
