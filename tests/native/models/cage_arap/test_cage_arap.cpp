// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/cage_arap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <vector>

#include "arap/error.h"
#include "support/cages.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::CageArap;
using arap::CageArapOptions;
using arap::CageCoordinates;
using arap::CageEnergy;
using arap::InitialGuess;
using arap::InvalidInput;
using arap::SolveResult;

CageArapOptions with(CageEnergy energy, CageCoordinates coordinates = CageCoordinates::kMeanValue) {
  CageArapOptions options;
  options.energy = energy;
  options.coordinates = coordinates;
  options.grid_spacing = .05;
  return options;
}

constexpr CageEnergy kBoth[] = {CageEnergy::kCage, CageEnergy::kMesh};

CageArap bound(const MeshData& mesh, const CageArapOptions& options = {}, int cells = 4) {
  return {mesh.mesh(), make_cage(mesh.mesh(), cells), options};
}

/// Of length 4 along x.
MeshData rod() { return bar(6, Faces::kQuads); }

/// Both ends held, the far one moved by a motion of each share of the way.
struct Ends {
  explicit Ends(const MeshData& mesh)
      : task(hold(mesh, extreme_vertices(mesh.positions(), longest_axis(mesh.positions()), .1))),
        n_low(static_cast<int>(task.constraints.vertices.size())) {
    for (const int v : extreme_vertices(mesh.positions(), longest_axis(mesh.positions()), -.1))
      task.add(v, mesh.vertices[v]);
  }

  [[nodiscard]] Positions targets(const RigidMotion& motion) const {
    Positions result = task.targets;
    result.bottomRows(result.rows() - n_low) = motion.apply(Positions(result.bottomRows(result.rows() - n_low)));
    return result;
  }

  Task task;
  int n_low;
};

RigidMotion twist(double degrees) { return {rotation_about({1, 0, 0}, degrees * 3.14159265358979 / 180), {0, 0, 0}}; }

TEST(CageArap, RestsAndMovesRigidly) {
  const MeshData mesh = bumpy_sphere(2);
  const Task rest = hold(mesh, extreme_vertices(mesh.positions(), 0, .3));
  const RigidMotion motion = Random(9).rigid_motion(1, .5);
  const Task moved = rigid_task(mesh, rest.constraints, motion);
  const Positions expected = motion.apply(mesh.positions());
  const double least = 1e-12 * mesh.diagonal();
  for (const CageEnergy energy : kBoth)
    for (const CageCoordinates coordinates : {CageCoordinates::kMeanValue, CageCoordinates::kHarmonic}) {
      CageArap solver = bound(mesh, with(energy, coordinates));
      solver.set_constraints(rest.constraints);
      EXPECT_LT(max_distance(solver.solve(rest.targets, to_accuracy(1e-11)).positions, mesh.positions()), least);
      EXPECT_LT(max_distance(solver.solve(moved.targets, to_accuracy(1e-11)).positions, expected), least);
    }
}

TEST(CageArap, AFewVerticesAreMetAndARegionNearly) {
  const MeshData mesh = rod();
  Task few = hold(mesh, {0, 40, 90});
  for (const int v : {300, 380}) few.add(v, mesh.vertices[v] + Vector3(.1, .4, .2));
  const Ends ends(mesh);
  for (const CageEnergy energy : kBoth) {
    CageArap solver = bound(mesh, with(energy), 8);
    solver.set_constraints(few.constraints);
    const auto off = [&](const Task& task, const Positions& targets) {
      return max_distance(rows(solver.solve(targets).positions, task.constraints.vertices), targets) / mesh.diagonal();
    };
    EXPECT_LT(off(few, few.targets), 1e-4);
    solver.set_constraints(ends.task.constraints);
    EXPECT_LT(off(ends.task, ends.targets({rotation_about({0, 0, 1}, 1), {0, 1, 0}})), 2e-3);
  }
}

TEST(CageArap, EnergyNeverRises) {
  const MeshData mesh = rod();
  const Ends ends(mesh);
  for (const CageEnergy energy : kBoth) {
    CageArap solver = bound(mesh, with(energy), 8);
    solver.set_constraints(ends.task.constraints);
    double last = std::numeric_limits<double>::infinity();
    for (int n = 1; n < 12; ++n) {
      solver.reset();
      const SolveResult result = solver.solve(ends.targets(twist(80)), plain_iterations(n, InitialGuess::kRest));
      EXPECT_LE(result.energy_after, last * (1 + 1e-9)) << n;
      last = result.energy_after;
    }
  }
}

TEST(CageArap, DoesNotHangOnTheUnit) {
  const MeshData mesh = rod();
  const Ends ends(mesh);
  for (const CageEnergy energy : kBoth) {
    Positions expected;
    for (const double unit : {1.0, .01, 100.0}) {
      const MeshData scaled = transformed(mesh, [&](const Vector3& x) { return Vector3(unit * x); });
      CageArap solver = bound(scaled, with(energy), 8);
      solver.set_constraints(ends.task.constraints);
      const Positions posed = solver.solve(unit * ends.targets(twist(60)), to_accuracy(1e-10)).positions / unit;
      if (unit == 1) expected = posed;
      EXPECT_LT(max_distance(posed, expected), 1e-7);
    }
  }
}

TEST(CageArap, HardlyHangsOnTheDensityOfTheMesh) {
  const MeshData coarse = triangulate(bar(6, Faces::kQuads));
  const MeshData fine = subdivide(coarse);
  const arap::PolygonMesh cage = make_cage(coarse.mesh(), 8);
  const auto pose = [&](const MeshData& mesh, CageEnergy energy) {
    Task task;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const Vector3& x = mesh.vertices[v];
      if (std::abs(x[0]) < 1.66) continue;  // up to a row of both
      task.add(v, x[0] < 0 ? x : twist(40).apply(x));
    }
    CageArap solver(mesh.mesh(), cage, with(energy));
    solver.set_constraints(task.constraints);
    return Positions(solver.solve(task.targets).positions.topRows(coarse.n_vertices()));
  };
  for (const CageEnergy energy : kBoth)
    EXPECT_LT(max_distance(pose(coarse, energy), pose(fine, energy)), 3e-3 * coarse.diagonal());
}

TEST(CageArap, OneLargeTurnEndsWhereManySmallOnesDo) {
  const MeshData mesh = rod();
  const Ends ends(mesh);
  for (const CageEnergy energy : kBoth) {
    CageArap solver = bound(mesh, with(energy), 8);
    solver.set_constraints(ends.task.constraints);
    Positions small_steps;
    for (int step = 1; step <= 10; ++step)
      small_steps = solver.solve(ends.targets(twist(13.5 * step)), to_accuracy(1e-8)).positions;
    for (const InitialGuess guess : {InitialGuess::kPrevious, InitialGuess::kHandleRotations}) {
      solver.reset();
      const Positions at_once = solver.solve(ends.targets(twist(135)), to_accuracy(1e-8, guess)).positions;
      EXPECT_LT(max_distance(at_once, small_steps), 1e-4 * mesh.diagonal());
    }
  }
}

TEST(CageArap, SoftVerticesGiveWay) {
  const MeshData mesh = rod();
  const Ends ends(mesh);
  double last = 10;
  for (const double strength : {.01, .3, .9, 1.0}) {
    Task task = ends.task;
    task.constraints.strengths.assign(task.constraints.vertices.size(), 1);
    for (size_t k = ends.n_low; k < task.constraints.strengths.size(); ++k) task.constraints.strengths[k] = strength;
    CageArap solver = bound(mesh, {}, 8);
    solver.set_constraints(task.constraints);
    const Positions targets = ends.targets({Matrix3::Identity(), {.5, 0, 0}});
    const double off = max_distance(rows(solver.solve(targets).positions, task.constraints.vertices), targets);
    EXPECT_LT(off, .8 * last);
    last = off;
  }
}

TEST(CageArap, PatchesAreHeldExactly) {
  const MeshData mesh = rod();
  Task task = hold(mesh, extreme_vertices(mesh.positions(), 0, .1));
  const std::vector<int> patch = extreme_vertices(mesh.positions(), 0, -.05);
  const std::vector<double> weights(patch.size(), 1);
  task.add_patch(patch, weights, average(mesh.positions(), patch, weights) + Vector3(.2, .9, 0));
  for (const CageEnergy energy : kBoth) {
    CageArap solver = bound(mesh, with(energy), 8);
    solver.set_constraints(task.constraints);
    const SolveResult result = solver.solve(task.targets);
    EXPECT_LT((average(result.positions, patch, weights).transpose() - task.targets.bottomRows(1)).norm(), 1e-9);
  }
}

TEST(CageArap, LooseVerticesStayAndGoToTheirTargets) {
  MeshData mesh = rod();
  const int stays = mesh.add_vertex({50, 0, 0});
  const int goes = mesh.add_vertex({0, -70, 0});
  Ends ends(rod());
  ends.task.add(goes, {1, 2, 3});
  for (const CageCoordinates coordinates : {CageCoordinates::kMeanValue, CageCoordinates::kHarmonic}) {
    CageArap solver(mesh.mesh(), make_cage(rod().mesh(), 8), with(CageEnergy::kCage, coordinates));
    solver.set_constraints(ends.task.constraints);
    const SolveResult result = solver.solve(ends.task.targets);
    EXPECT_EQ(result.loose_vertices, (std::vector<int>{stays, goes}));
    EXPECT_LT((result.positions.row(stays) - Eigen::RowVector3d(50, 0, 0)).norm(), 1e-12);
    EXPECT_LT((result.positions.row(goes) - Eigen::RowVector3d(1, 2, 3)).norm(), 1e-12);
    EXPECT_LT(max_distance(result.positions.topRows(rod().n_vertices()), rod().positions()), 1e-6);
  }
}

/// Of the cage, with the parts of the mesh in it; with mean values those feel a shell beside them.
/// They neither soften what holds the mesh nor take digits from it.
TEST(CageArap, LooseVerticesOfTheCageChangeNothing) {
  const MeshData mesh = rod();
  const Ends ends(mesh);
  const Positions targets = ends.targets({rotation_about({0, 0, 1}, 1), {0, 1, 0}});
  const arap::PolygonMesh cage = make_cage(mesh.mesh(), 4);
  MeshData with_loose{"", {}, {}};
  for (int k = 0; k < 50; ++k) with_loose.add_vertex(Vector3(1e7, k, 0));
  for (int v = 0; v < cage.n_vertices(); ++v) with_loose.add_vertex(cage.positions().row(v).transpose());
  for (int f = 0; f < cage.n_faces(); ++f) {
    with_loose.faces.emplace_back();
    for (const int v : cage.face(f)) with_loose.faces.back().push_back(50 + v);
  }
  for (const CageEnergy energy : kBoth) {
    CageArap solver(mesh.mesh(), cage, with(energy));
    CageArap beside(mesh.mesh(), with_loose.mesh(), with(energy));
    EXPECT_EQ(beside.n_cage_vertices(), 50 + cage.n_vertices());
    for (CageArap* each : {&solver, &beside}) each->set_constraints(ends.task.constraints);
    EXPECT_LT(max_distance(beside.solve(targets).positions, solver.solve(targets).positions), 1e-12);
    EXPECT_EQ(beside.cage_positions().topRows(50), with_loose.positions().topRows(50));
    EXPECT_LT(max_distance(beside.cage_positions().bottomRows(cage.n_vertices()), solver.cage_positions()), 1e-12);
  }
}

TEST(CageArap, AShellWithoutConstraintsStays) {
  const MeshData near = rod();
  const Ends ends(near);
  // Cubes of the cage of one size.
  for (const auto& [shift, cells, most] : {std::tuple{9.0, 20, .02}, std::tuple{2.0, 8, .2}}) {
    const Vector3 beside(0, shift, 0);
    const MeshData mesh = join(near, transformed(near, [&](const Vector3& x) { return Vector3(x + beside); }));
    const Positions rest = mesh.positions().bottomRows(near.n_vertices());
    for (const CageEnergy energy : kBoth)
      for (const CageCoordinates coordinates : {CageCoordinates::kMeanValue, CageCoordinates::kHarmonic}) {
        CageArap solver = bound(mesh, with(energy, coordinates), cells);
        solver.set_constraints(ends.task.constraints);
        const SolveResult result = solver.solve(ends.targets(twist(40)));
        EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
        EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
        EXPECT_LT(max_distance(rows(result.positions, ends.task.constraints.vertices), ends.targets(twist(40))), .01);
        const double moved = max_distance(result.positions.bottomRows(near.n_vertices()), rest);
        EXPECT_LT(moved, coordinates == CageCoordinates::kHarmonic ? 1e-6 : most);
      }
  }
}

TEST(CageArap, ShellsThatShareAMeshMoveRigidlyWithIt) {
  const auto moved_box = [](const Vector3& size, const Vector3& shift) {
    return transformed(box({1, 1, 1}, size, Faces::kQuads), [&](const Vector3& x) { return Vector3(x + shift); });
  };
  const MeshData mesh = rod();
  std::vector<int> ends = extreme_vertices(mesh.positions(), 0, .1);
  for (const int v : extreme_vertices(mesh.positions(), 0, -.1)) ends.push_back(v);
  std::vector<int> whole(mesh.n_vertices());
  std::iota(whole.begin(), whole.end(), 0);
  struct Case {
    MeshData cage;
    std::vector<int> held;
  };
  const Case one_above_the_other{join(moved_box({2.2, 2, 2}, {-1.3, 0, 0}), moved_box({2.2, 2, 2}, {1.3, 0, 0})),
                                 whole};
  const Case hollow{join(moved_box({6, 3, 3}, {0, 0, 0}), flipped(moved_box({3, .3, .3}, {0, 0, 0}))), ends};
  const RigidMotion motion = Random(3).rigid_motion(2, .5);
  for (const Case& of : {one_above_the_other, hollow})
    for (const CageEnergy energy : kBoth) {
      const Task task = rigid_task(mesh, hold(mesh, of.held).constraints, motion);
      CageArap solver(mesh.mesh(), of.cage.mesh(), with(energy));
      solver.set_constraints(task.constraints);
      const SolveResult result = solver.solve(task.targets, to_accuracy(1e-11));
      EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-9);
      EXPECT_TRUE(result.parts_at_rest.empty());
    }
}

TEST(CageArap, StartsFromPositionsAndGoesBackToRest) {
  const MeshData mesh = rod();
  const Ends ends(mesh);
  CageArap solver = bound(mesh, {}, 8);
  solver.set_constraints(ends.task.constraints);
  const Positions posed = solver.solve(ends.targets(twist(60)), to_accuracy(1e-9)).positions;
  EXPECT_LT(max_distance(solver.positions(), posed), 1e-12);
  const Positions cage = solver.cage_positions();
  solver.reset();
  EXPECT_LT(max_distance(solver.positions(), mesh.positions()), 1e-12);
  EXPECT_GT(max_distance(solver.cage_positions(), cage), .5);
  solver.set_positions(posed);
  EXPECT_LT(max_distance(solver.positions(), posed), 1e-3);
  EXPECT_LT(solver.solve(ends.targets(twist(60)), iterations(1)).step, 1e-2);
}

TEST(CageArap, ACancelledSolveChangesNothing) {
  const MeshData mesh = rod();
  const Ends ends(mesh);
  CageArap solver = bound(mesh, {}, 8);
  solver.set_constraints(ends.task.constraints);
  const Positions posed = solver.solve(ends.targets(twist(60))).positions;
  std::vector<float> out(3 * static_cast<size_t>(mesh.n_vertices()));
  const auto stop = [](double) { return false; };
  EXPECT_EQ(solver.solve(ends.targets(twist(90)), {}, {}, stop, out).stop_reason, arap::StopReason::kCancelled);
  EXPECT_LT(max_distance(solver.positions(), posed), 1e-12);
  EXPECT_NEAR(out[0], posed(0, 0), 1e-6);
}

TEST(CageArap, TellsWhatItIsAndWhatIsWrong) {
  const MeshData mesh = rod();
  const arap::PolygonMesh cage = make_cage(mesh.mesh(), 8);
  CageArapOptions options;
  options.threads = 2;
  CageArap solver(mesh.mesh(), cage, options);
  EXPECT_EQ(solver.n_vertices(), mesh.n_vertices());
  EXPECT_EQ(solver.n_cage_vertices(), cage.n_vertices());
  EXPECT_EQ(solver.n_parts(), 1);
  EXPECT_EQ(solver.threads(), 2);
  EXPECT_EQ(solver.n_factorizations(), 0);
  solver.set_constraints(hold(mesh, {0}).constraints);
  EXPECT_EQ(solver.n_factorizations(), 1);
  expect_error<InvalidInput>([&] { CageArap(mesh.mesh(), cage, with(CageEnergy::kCage, CageCoordinates::kGreen)); },
                             {"Green coordinates are not linear in the cage; take mean value or harmonic coordinates"});
  expect_error<InvalidInput>(
      [&] {
        CageArap(MeshData{"", mesh.vertices, {}}.mesh(), cage);
      },
      {"no faces or no size; give it faces"});
}

}  // namespace
}  // namespace arap_test
