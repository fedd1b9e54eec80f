// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "models/surface_arap/surface_model.h"
#include "optimize/nonlinear_cg.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InitialGuess;
using arap::InvalidInput;
using arap::SolveResult;
using arap::SurfaceArap;

/// Region 0: the vertices with `is_inside`.
std::vector<int> region_where(const MeshData& mesh, const std::function<bool(const Vector3&)>& is_inside) {
  std::vector<int> regions;
  for (const Vector3& p : mesh.vertices) regions.push_back(is_inside(p) ? 0 : -1);
  return regions;
}

std::vector<int> members(const std::vector<int>& regions, int region) {
  std::vector<int> result;
  for (size_t v = 0; v < regions.size(); ++v)
    if (regions[v] == region) result.push_back(static_cast<int>(v));
  return result;
}

MeshData long_bar() { return bar(3, Faces::kQuads); }

/// The middle of long_bar.
std::vector<int> middle_region() {
  return region_where(long_bar(), [](const Vector3& p) { return std::abs(p.x()) < .7; });
}

Task bar_task(double angle_rad = 1) {
  return bend_task(long_bar(), {rotation_about({.3, 1, .2}, angle_rad), {-.3, .2, .5}});
}

/// The reference's best rotations, but one for all cells of each region: that of the region's motion.
std::vector<Matrix3> shared_rotations(const ModelReference& plain, const MeshData& mesh,
                                      const std::vector<int>& regions, const Positions& p) {
  std::vector<Matrix3> rotations = plain.rotations(p);
  for (int region = 0; region <= *std::max_element(regions.begin(), regions.end()); ++region) {
    const std::vector<int> inside = members(regions, region);
    if (inside.size() < 3) continue;
    const RigidMotion motion = best_rigid_motion(rows(mesh.positions(), inside), rows(p, inside));
    for (size_t c = 0; c < rotations.size(); ++c)
      if (regions[plain.homes[c]] == region) rotations[c] = motion.rotation;
  }
  return rotations;
}

/// A motion of a region to first order: along `axis`, or about `axis` through `centre`.
struct Direction {
  bool is_turn;
  Vector3 axis;
  Vector3 centre;
};

std::vector<Direction> turns_about(const Vector3& centre) {
  return {{true, Vector3::UnitX(), centre}, {true, Vector3::UnitY(), centre}, {true, Vector3::UnitZ(), centre}};
}

std::vector<Direction> all_directions() {
  std::vector<Direction> directions = turns_about({.1, .2, .3});
  for (int axis = 0; axis < 3; ++axis) directions.push_back({false, Vector3::Unit(axis), Vector3::Zero()});
  return directions;
}

class RigidRegions : public OfEachModel {
 protected:
  /// Expects region 0 rigid, hard vertices outside of it at their targets, and the energy never to rise, iteration by
  /// iteration.
  void expect_rigid_and_monotone(const MeshData& mesh, const std::vector<int>& regions, const Task& task,
                                 const char* what) const {
    SurfaceArap solver(mesh.mesh(), options(), with_regions(regions));
    solver.set_constraints(task.constraints);
    const Positions rest = mesh.positions();
    expect_energy_never_rises(solver, mesh, task.targets, 60, what);
    for (const int k : {1, 2, 5, 20, 60}) {
      const SolveResult result = solver.solve(task.targets, iterations(k, InitialGuess::kRest));
      for (int region = 0; region <= *std::max_element(regions.begin(), regions.end()); ++region)
        EXPECT_LT(off_rigid(rest, result.positions, members(regions, region)), 1e-6 * mesh.diagonal())
            << what << ", region " << region << ", iteration " << k;
      for (size_t c = 0; c < task.constraints.vertices.size(); ++c) {
        if (task.constraints.strengths[c] < 1) continue;
        EXPECT_LT((result.positions.row(task.constraints.vertices[c]) - task.targets.row(static_cast<Eigen::Index>(c)))
                      .norm(),
                  1e-9 * mesh.diagonal())
            << what;
      }
    }
  }

  /// Expects that no small motion of region 0 in one of `directions`, and no free vertex, lowers the energy.
  void expect_stationary(const MeshData& mesh, const std::vector<int>& regions, const Task& task,
                         const SolveResult& result, const std::vector<Direction>& directions) const {
    const ModelReference plain = reference(mesh, {}, regions);
    const std::vector<int> inside = members(regions, 0);
    const std::vector<Matrix3> rotations = shared_rotations(plain, mesh, regions, result.positions);
    const auto energy = [&](const Direction& direction, double size) {
      const Matrix3 turn = direction.is_turn ? rotation_about(direction.axis, size) : Matrix3::Identity();
      const Vector3 shift = direction.is_turn ? Vector3::Zero() : Vector3(size * direction.axis);
      Positions p = result.positions;
      std::vector<Matrix3> turned = rotations;
      for (const int v : inside) {
        const Vector3 arm = p.row(v).transpose() - direction.centre;
        p.row(v) = (direction.centre + turn * arm + shift).transpose();
      }
      for (size_t c = 0; c < turned.size(); ++c)
        if (regions[plain.homes[c]] == 0) turned[c] = turn * rotations[c];
      return plain.energy(p, turned) + plain.soft_energy(task.constraints, task.targets, p);
    };
    const double h = 1e-5;
    const Positions force = plain.gradient(result.positions, rotations);
    const double scale = force.cwiseAbs().maxCoeff();
    EXPECT_GT(scale, 1e-3) << "the handles must pull at all";
    for (const Direction& direction : directions)
      EXPECT_NEAR((energy(direction, h) - energy(direction, -h)) / (2 * h), 0, 1e-5 * scale)
          << (direction.is_turn ? "turn" : "shift") << direction.axis.transpose();
    const auto& held = task.constraints.vertices;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const bool is_free = regions[v] < 0 && std::find(held.begin(), held.end(), v) == held.end();
      EXPECT_LT(is_free ? force.row(v).norm() : 0, 1e-5 * scale) << v;
    }
  }

  /// Expects that no small turn of region 0, with the vertex outside moved against the one inside, lowers the energy.
  void expect_turns_with_patch_cost_nothing(const MeshData& mesh, const std::vector<int>& regions,
                                            const Positions& positions, int inside, int outside) const {
    const ModelReference plain = reference(mesh, {}, regions);
    const std::vector<Matrix3> rotations = shared_rotations(plain, mesh, regions, positions);
    const auto energy = [&](const Matrix3& turn, const Vector3& centre) {
      Positions p = positions;
      for (const int v : members(regions, 0)) p.row(v) = (centre + turn * (p.row(v).transpose() - centre)).transpose();
      p.row(outside) -= p.row(inside) - positions.row(inside);
      std::vector<Matrix3> turned = rotations;
      for (size_t c = 0; c < turned.size(); ++c)
        if (regions[plain.homes[c]] == 0) turned[c] = turn * rotations[c];
      return plain.energy(p, turned);
    };
    const double h = 1e-5;
    const double scale = plain.gradient(positions, rotations).cwiseAbs().maxCoeff();
    for (const Direction& turn : turns_about({.1, .2, .3}))
      EXPECT_NEAR(
          (energy(rotation_about(turn.axis, h), turn.centre) - energy(rotation_about(turn.axis, -h), turn.centre)) /
              (2 * h),
          0, 1e-5 * scale)
          << turn.axis.transpose();
  }
};

/// What solves of one iteration each come to, from rest.
struct Course {
  bool has_risen = false;
  bool has_converged = false;
  Positions end;
};

Course follow(SurfaceArap& solver, const Positions& targets) {
  arap::SolveOptions one;
  one.max_iterations = 1;
  solver.reset();
  Course course;
  double last = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 500 && !course.has_converged; ++n) {
    const SolveResult result = solver.solve(targets, one);
    course.has_risen = course.has_risen || result.energy_after > last * (1 + 1e-9) + 1e-12;
    course.has_converged = result.stop_reason == arap::StopReason::kConverged;
    last = result.energy_after;
    course.end = result.positions;
  }
  return course;
}

TEST_P(RigidRegions, FreeRegionMovesAsOneAndRestsWhereNothingPullsItOn) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  expect_rigid_and_monotone(mesh, regions, bar_task(), "free");
  expect_rigid_and_monotone(mesh, regions, bar_task(2.8), "free, great bend");
  const SolveResult result = solve_once(mesh, bar_task(), to_accuracy(1e-11), options(), with_regions(regions));
  EXPECT_GT(max_distance(rows(result.positions, members(regions, 0)), rows(mesh.positions(), members(regions, 0))), .1);
  expect_stationary(mesh, regions, bar_task(), result, all_directions());
}

TEST_P(RigidRegions, RegionWithOneHardVertexTurnsAboutIt) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const int inside = members(regions, 0).front();
  Task task = bar_task();
  const Vector3 target = mesh.vertices[inside] + Vector3(0, .1, .3);
  task.add(inside, target);
  expect_rigid_and_monotone(mesh, regions, task, "one hard vertex");
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-11), options(), with_regions(regions));
  expect_stationary(mesh, regions, task, result, turns_about(target));
}

TEST_P(RigidRegions, RegionWithTwoHardVerticesTurnsAboutTheirLine) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const std::vector<int> inside = members(regions, 0);
  const RigidMotion motion{rotation_about({1, 1, 0}, .4), {.05, .1, .3}};
  Task task = bar_task();
  const Vector3 first = motion.apply(mesh.vertices[inside.front()]);
  const Vector3 second = motion.apply(mesh.vertices[inside.back()]);
  task.add(inside.front(), first);
  task.add(inside.back(), second);
  expect_rigid_and_monotone(mesh, regions, task, "two hard vertices");
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-11), options(), with_regions(regions));
  expect_stationary(mesh, regions, task, result, {{true, (second - first).normalized(), first}});
}

TEST_P(RigidRegions, RegionWithThreeHardVerticesIsWhereTheySay) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const std::vector<int> inside = members(regions, 0);
  const RigidMotion motion{rotation_about({1, 1, 0}, .4), {.05, .1, .3}};
  Task task = bar_task();
  for (const int v : {inside.front(), inside[1], inside.back()}) task.add(v, motion.apply(mesh.vertices[v]));
  expect_rigid_and_monotone(mesh, regions, task, "three hard vertices");
  const SolveResult result = solve_once(mesh, task, iterations(1), options(), with_regions(regions));
  const Positions expected = motion.apply(rows(mesh.positions(), inside));
  EXPECT_LT(max_distance(rows(result.positions, inside), expected), 1e-9);
}

TEST_P(RigidRegions, RegionWithSoftVerticesRestsWhereNothingPullsItOn) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const std::vector<int> inside = members(regions, 0);
  Task task = bar_task();
  for (const int v : {inside.front(), inside[5], inside.back()}) task.add(v, mesh.vertices[v] + Vector3(0, .2, .4), .4);
  expect_rigid_and_monotone(mesh, regions, task, "soft vertices");
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-11), options(), with_regions(regions));
  expect_stationary(mesh, regions, task, result, all_directions());
}

TEST_P(RigidRegions, AdjacentRegionsMoveAsOneEach) {
  const MeshData mesh = long_bar();
  std::vector<int> regions = region_where(mesh, [](const Vector3& p) { return p.x() > -.9 && p.x() < .1; });
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (regions[v] < 0 && mesh.vertices[v].x() >= .1 && mesh.vertices[v].x() < 1) regions[v] = 1;
  expect_rigid_and_monotone(mesh, regions, bar_task(), "two regions side by side");
  const SolveResult result = solve_once(mesh, bar_task(), to_accuracy(1e-11), options(), with_regions(regions));
  expect_stationary(mesh, regions, bar_task(), result, all_directions());
}

Vector3 middle_of(const Positions& p, int a, int b) { return (p.row(a) + p.row(b)).transpose() / 2; }

TEST_P(RigidRegions, PatchInARegionMeetsItsTarget) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const std::vector<int> inside = members(regions, 0);
  Task task = bar_task();
  const Vector3 target = middle_of(mesh.positions(), inside[0], inside[4]) + Vector3(0, 0, .5);
  task.add_patch({inside[0], inside[4]}, {1, 1}, target);
  expect_rigid_and_monotone(mesh, regions, task, "patch inside");
  for (const int n : {1, 2, 5, 50}) {
    const Positions p = solve_once(mesh, task, iterations(n), options(), with_regions(regions)).positions;
    EXPECT_LT((middle_of(p, inside[0], inside[4]) - target).norm(), 1e-9 * mesh.diagonal()) << n;
  }
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-11), options(), with_regions(regions));
  expect_stationary(mesh, regions, task, result, turns_about(target));
}

TEST_P(RigidRegions, PatchHalfInARegionMeetsItsTarget) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const int inside = members(regions, 0)[8];
  const int outside = static_cast<int>(std::find_if(mesh.vertices.begin(), mesh.vertices.end(),
                                                    [](const Vector3& p) { return p.x() > .9 && p.x() < 1.1; }) -
                                       mesh.vertices.begin());
  ASSERT_LT(regions[outside], 0);
  Task task = bar_task();
  const Vector3 target = middle_of(mesh.positions(), inside, outside) + Vector3(0, .2, .5);
  task.add_patch({inside, outside}, {1, 1}, target);
  for (const int n : {1, 2, 5, 50}) {
    const Positions p = solve_once(mesh, task, iterations(n), options(), with_regions(regions)).positions;
    EXPECT_LT((middle_of(p, inside, outside) - target).norm(), 1e-9 * mesh.diagonal()) << n;
    EXPECT_LT(off_rigid(mesh.positions(), p, members(regions, 0)), 1e-6 * mesh.diagonal()) << n;
  }
  expect_rigid_and_monotone(mesh, regions, task, "patch half inside");
  SurfaceArap solver(mesh.mesh(), options(), with_regions(regions));
  solver.set_constraints(task.constraints);
  const SolveResult result = solver.solve(task.targets, to_accuracy(1e-10));
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  EXPECT_LT(result.energy_after, result.energy_before);
  const SolveResult more = solver.solve(task.targets, to_accuracy(1e-10));
  EXPECT_LT(max_distance(more.positions, result.positions), 1e-6) << "converged is where another solve stays";
  expect_turns_with_patch_cost_nothing(mesh, regions, result.positions, inside, outside);
}

TEST_P(RigidRegions, StepIsTheLargestMovementThatOfATurnToo) {
  const MeshData mesh = long_bar();
  // Two regions that cover the mesh, one hard vertex each: all that is free are their turns.
  const std::vector<int> halves = region_where(mesh, [](const Vector3& p) { return p.x() < .1; });
  std::vector<int> covering = halves;
  std::replace(covering.begin(), covering.end(), -1, 1);
  Task apart = hold(mesh, {0});
  const int last = mesh.n_vertices() - 1;
  ASSERT_NE(covering[0], covering[last]);
  apart.add(last, mesh.vertices[last] + Vector3(0, .5, 1));
  struct Case {
    std::vector<int> regions;
    Task task;
  };
  for (const auto& [regions, task] : {Case{covering, apart}, Case{middle_region(), bar_task()}}) {
    SurfaceArap solver(mesh.mesh(), options(), with_regions(regions));
    solver.set_constraints(task.constraints);
    Positions before = solver.solve(task.targets, iterations(1, InitialGuess::kRest)).positions;
    for (int n = 2; n < 6; ++n) {
      const SolveResult result = solver.solve(task.targets, iterations(n, InitialGuess::kRest));
      const double moved = max_distance(result.positions, before) / mesh.diagonal();
      EXPECT_GT(moved, 1e-9);
      EXPECT_NEAR(result.step, moved, 1e-6 * moved) << "iteration " << n;
      before = result.positions;
    }
  }
}

TEST_P(RigidRegions, ReportedEnergyIsThatOfThePositionsWithTheRegionsRotation) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const ModelReference plain = reference(mesh, {}, regions);
  const auto expected = [&](const SolveResult& result) {
    return plain.energy(result.positions, shared_rotations(plain, mesh, regions, result.positions));
  };
  const SolveResult converged = solve_once(mesh, bar_task(), to_accuracy(1e-11), options(), with_regions(regions));
  EXPECT_NEAR(converged.energy_after, expected(converged), 1e-9 * converged.energy_after);
  // Before, the other cells may lag behind the region by one fit, but never report too little.
  const SolveResult early = solve_once(mesh, bar_task(), iterations(8), options(), with_regions(regions));
  EXPECT_GE(early.energy_after, expected(early) * (1 - 1e-12));
  EXPECT_LE(early.energy_after, expected(early) * 1.01);
}

TEST_P(RigidRegions, AllHandlesMovedByOneRigidMotionMoveEverythingByIt) {
  const MeshData mesh = long_bar();
  const RigidMotion motion = Random(81).rigid_motion(.7, 1);
  const Task task = rigid_task(mesh, bar_task().constraints, motion);
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-9), options(), with_regions(middle_region()));
  EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-6 * mesh.diagonal());
  const SolveResult guessed =
      solve_once(mesh, task, iterations(1, InitialGuess::kHandleRotations), options(), with_regions(middle_region()));
  EXPECT_LT(max_distance(guessed.positions, motion.apply(mesh.positions())), 1e-7 * mesh.diagonal());
}

TEST_P(RigidRegions, RegionOfOneVertexIsNoRegion) {
  const MeshData mesh = long_bar();
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  regions[mesh.n_vertices() / 2] = 0;
  const Positions with = solve_once(mesh, bar_task(), to_accuracy(1e-11), options(), with_regions(regions)).positions;
  EXPECT_LT(max_distance(with, solve_once(mesh, bar_task(), to_accuracy(1e-11), options()).positions), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(AllModels, RigidRegions, testing::ValuesIn(all_models()), model_name);

TEST(RigidRegion, OfTheWholeMeshIsTheBestFitToItsSoftTargets) {
  const MeshData mesh = bumpy_sphere(1);
  Random random(82);
  Task task;
  const RigidMotion motion = random.rigid_motion(1.2, 1);
  for (int v = 0; v < mesh.n_vertices(); v += 3)
    task.add(v, motion.apply(mesh.vertices[v]) + random.vector(.2), random.uniform(.1, .9));
  const Reference plain(mesh, arap::Energy::kSpokesAndRims, arap::EdgeWeights::kCotangent);
  const std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), 0);
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-12), {}, with_regions(regions));
  // The weighted fit in closed form.
  const Eigen::MatrixXd K = plain.matrix();
  Vector3 from = Vector3::Zero();
  Vector3 to = Vector3::Zero();
  double sum = 0;
  const auto omega = [&](size_t k) {
    const double s = task.constraints.strengths[k];
    return K(task.constraints.vertices[k], task.constraints.vertices[k]) * s / (1 - s);
  };
  for (size_t k = 0; k < task.constraints.vertices.size(); ++k) {
    from += omega(k) * mesh.vertices[task.constraints.vertices[k]];
    to += omega(k) * task.targets.row(static_cast<Eigen::Index>(k)).transpose();
    sum += omega(k);
  }
  from /= sum;
  to /= sum;
  Matrix3 S = Matrix3::Zero();
  for (size_t k = 0; k < task.constraints.vertices.size(); ++k)
    S += omega(k) * (task.targets.row(static_cast<Eigen::Index>(k)).transpose() - to) *
         (mesh.vertices[task.constraints.vertices[k]] - from).transpose();
  const Matrix3 R = best_rotation(S);
  EXPECT_LT(max_distance(result.positions, RigidMotion{R, to - R * from}.apply(mesh.positions())), 1e-6);
}

TEST(RigidRegion, LabelsAreOnlyLabels) {
  const MeshData mesh = long_bar();
  std::vector<int> regions = middle_region();
  const Positions expected = solve_once(mesh, bar_task(), iterations(10), {}, with_regions(regions)).positions;
  for (int& region : regions) region = region == 0 ? 1000000 : -7;
  EXPECT_EQ(solve_once(mesh, bar_task(), iterations(10), {}, with_regions(regions)).positions, expected);
}

TEST(RigidRegion, NoVertexInAnyRegionIsAsWithoutRegions) {
  const MeshData mesh = long_bar();
  const std::vector<int> none(static_cast<size_t>(mesh.n_vertices()), -1);
  EXPECT_EQ(solve_once(mesh, bar_task(), iterations(10), {}, with_regions(none)).positions,
            solve_once(mesh, bar_task(), iterations(10)).positions);
}

TEST(RigidRegion, AcrossTwoPartsHoldsThemTogether) {
  const MeshData mesh = two_spheres(1);
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  const int n = mesh.n_vertices() / 2;
  for (const int v : {0, 5, 9, n + 3, n + 8, n + 20}) regions[v] = 0;
  const RigidMotion motion = Random(83).rigid_motion(.6, 1);
  arap::ConstraintSet set{{20, 21, 22, 30}, {1, 1, 1, 1}, {}};
  const SolveResult result =
      solve_once(mesh, rigid_task(mesh, set, motion), to_accuracy(1e-10), {}, with_regions(regions));
  EXPECT_TRUE(result.parts_at_rest.empty()) << "the second part hangs on the first";
  EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-5 * mesh.diagonal());
}

TEST(RigidRegion, WithoutAnyConstraintStaysAtRest) {
  const MeshData mesh = two_spheres(1);
  const int n = mesh.n_vertices() / 2;
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  for (int v = n; v < n + 10; ++v) regions[v] = 0;
  Task task = hold(mesh, {0, 1});
  task.targets.array() += 1;
  const SolveResult result = solve_once(mesh, task, iterations(5), {}, with_regions(regions));
  EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
  EXPECT_LT(max_distance(result.positions.bottomRows(n), mesh.positions().bottomRows(n)), 1e-12);
}

TEST(RigidRegion, OnALineOrOfTwoVerticesIsRigidToo) {
  const MeshData mesh = long_bar();
  std::vector<int> row =
      region_where(mesh, [](const Vector3& p) { return std::abs(p.x()) < 1 && p.y() > .49 && p.z() > .49; });
  std::vector<int> two(static_cast<size_t>(mesh.n_vertices()), -1);
  two[members(row, 0).front()] = two[members(row, 0)[1]] = 0;
  for (const std::vector<int>& regions : {row, two}) {
    const SolveResult result = solve_once(mesh, bar_task(), to_accuracy(1e-8), {}, with_regions(regions));
    EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
    EXPECT_LT(off_rigid(mesh.positions(), result.positions, members(regions, 0)), 1e-6 * mesh.diagonal());
  }
}

TEST(RigidRegion, WhoseHardTargetsAreNotRigidFollowsThemAsFarAsItCan) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const std::vector<int> inside = members(regions, 0);
  Task task = bar_task();
  for (const int v : {inside.front(), inside[7], inside.back()}) task.add(v, 1.3 * mesh.vertices[v]);
  const SolveResult result = solve_once(mesh, task, iterations(20), {}, with_regions(regions));
  EXPECT_TRUE(result.positions.allFinite());
  EXPECT_LT(off_rigid(mesh.positions(), result.positions, inside), 1e-6 * mesh.diagonal());
  EXPECT_LT(max_distance(rows(result.positions, inside), 1.3 * rows(mesh.positions(), inside)), .5);
}

TEST(RigidRegion, FirstStepOfADragIsTheMovementFromWhereTheRegionsAreAtTheirTargets) {
  const MeshData mesh = long_bar();
  std::vector<int> halves;
  for (const Vector3& p : mesh.vertices) halves.push_back(p.x() < 0 ? 0 : 1);
  const Task rest = hold(mesh, {extreme_vertices(mesh.positions(), 0, .001).front(),
                                extreme_vertices(mesh.positions(), 0, -.001).front()});
  const Vector3 shift = .3 * mesh.diagonal() * Vector3::UnitZ();
  Positions targets = rest.targets;
  targets.row(1) += shift.transpose();
  SurfaceArap solver(mesh.mesh(), {}, with_regions(halves));
  solver.set_constraints(rest.constraints);
  solver.solve(rest.targets, iterations(1, InitialGuess::kRest));
  Positions before = mesh.positions();
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (halves[v] == 1) before.row(v) += shift.transpose();
  const SolveResult result = solver.solve(targets, iterations(1));
  EXPECT_NEAR(result.step, max_distance(before, result.positions) / mesh.diagonal(), 1e-9);
  EXPECT_GT(result.step, .001);
}

TEST(RigidRegion, LabelsOfAnotherLengthAreRefusedWithBothLengths) {
  const MeshData mesh = cube();
  expect_error<InvalidInput>(
      [&] {
        SurfaceArap solver(mesh.mesh(), {}, with_regions({0, 0, 0}));
      },
      {"rigid_regions", "3", "8"});
}

// The energy's cells are groups of vertices, numbered as they like.

/// Cell order[k] becomes cell k.
void renumber_cells(arap::CellEnergy& energy, const std::vector<int>& order) {
  std::vector<std::vector<CellEntry>> cells;
  for (const int c : order) cells.push_back(entries_of(energy.cells, c));
  energy.cells = make_cells(energy.n_vertices(), cells);
}

/// Vertices after some iterations, with the cells in the given order.
Positions pose_with_cells(const MeshData& mesh, const Task& task, const std::vector<int>& regions,
                          const std::vector<int>& cell_order) {
  arap::SurfaceModel surface;
  arap::PreparedModel& model = surface.prepared;
  const double size = mesh.diagonal();
  arap::Options options;
  options.solver_factory = exact_solver();
  MeshData of_size_1 = mesh;
  for (Vector3& vertex : of_size_1.vertices) vertex /= size;
  const std::vector<int> numbers = prepare_surface(surface, of_size_1.mesh(), options, {}, regions, {});
  renumber_cells(model.energy, cell_order);
  model.regions = arap::RigidRegions(regions, model.energy, model.rest);
  model.regions.read_cells(model.energy.cells);
  arap::ConstraintSet set = task.constraints;
  for (int& v : set.vertices) v = numbers[v];
  const arap::PreparedConstraints constraints(model, {set, {}}, {});
  arap::LocalGlobal steps(model, constraints);
  steps.set_targets(task.targets / size, arap::Precision::kDouble);
  arap::Pose pose{model.rest, arap::Rotations(cell_order.size(), Eigen::Quaterniond::Identity()),
                  constraints.regions.fit_placements(model.rest)};
  steps.impose_constraints(pose);
  arap::NonlinearCg search(steps);
  arap::TimeBudget time(std::numeric_limits<double>::infinity());
  minimize(steps, search, pose, iterations(15), {}, time, std::nullopt, [] {});
  return pose.positions;
}

TEST(RigidRegion, HasTheCellsThatAreAtHomeInIt) {
  const MeshData mesh = bumpy_sphere(2);
  const Task task = bend_task(mesh, default_bend(mesh));
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.vertices[v].x() > .5 * mesh.positions().col(0).maxCoeff()) regions[v] = 3;
  std::vector<int> order(regions.size());
  std::iota(order.begin(), order.end(), 0);
  const Positions expected = pose_with_cells(mesh, task, regions, order);
  std::reverse(order.begin(), order.end());
  EXPECT_LT(max_distance(pose_with_cells(mesh, task, regions, order), expected), 1e-9);
  EXPECT_GT(max_distance(expected, mesh.positions() / mesh.diagonal()), .05);
}

TEST(RigidRegions, SolvesThatGoOnConvergeWithAPatchThatIsPartlyInARegion) {
  const MeshData mesh = bar(5, Faces::kTriangles);
  const Positions rest = mesh.positions();
  const double length = rest.col(0).maxCoeff() - rest.col(0).minCoeff();
  arap::VertexProperties properties;
  properties.rigid_regions = region_where(mesh, [&](const Vector3& p) { return p.x() > -.15 * length && p.x() < 0; });
  Task task;
  for (const int v : extreme_vertices(rest, 0, .1, 3)) task.add(v, rest.row(v).transpose());
  std::vector<int> patch;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(rest(v, 0) - .025 * length) < .125 * length && rest(v, 2) > 0) patch.push_back(v);
  const Vector3 middle = rows(rest, patch).colwise().mean().transpose();
  const double size = mesh.diagonal();
  task.add_patch(patch, std::vector<double>(patch.size(), 1), middle + size * Vector3(-.1, .2, .05));
  SurfaceArap at_once(mesh.mesh(), {}, properties);
  at_once.set_constraints(task.constraints);
  const SolveResult expected = at_once.solve(task.targets, iterations(1000));
  for (const int at_a_time : {1, 4, 8}) {
    SurfaceArap solver(mesh.mesh(), {}, properties);
    solver.set_constraints(task.constraints);
    arap::SolveOptions options;
    options.max_iterations = at_a_time;
    SolveResult result;
    for (int n = 0; n < 200 && result.stop_reason != arap::StopReason::kConverged; n += at_a_time)
      result = solver.solve(task.targets, options);
    EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged) << at_a_time;
    EXPECT_LT(result.energy_after, 1.001 * expected.energy_after) << at_a_time;
  }
}

/// A bar held at one end, with a region and two point handles at its border, one of them well inside.
struct TwoPatches {
  MeshData mesh = bar(6, Faces::kQuads);
  std::vector<int> regions;
  std::vector<double> shares;  ///< of each patch in the region
  Task task;
  std::optional<SurfaceArap> solver;

  explicit TwoPatches(unsigned seed) {
    Random random(seed);
    const Positions rest = mesh.positions();
    const double size = mesh.diagonal();
    const auto one_of = [&](size_t n) { return static_cast<int>(random.uniform(0, .999) * static_cast<double>(n)); };
    const Vector3 centre = rest.row(one_of(mesh.n_vertices())).transpose();
    const double radius = random.uniform(.12, .3) * size;
    const auto distance = [&](int v) { return (rest.row(v).transpose() - centre).norm(); };
    regions = region_where(mesh, [&](const Vector3& p) { return (p - centre).norm() < radius; });
    std::vector<int> border;
    std::vector<int> inside;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      if (std::abs(distance(v) - radius) < .06 * size) border.push_back(v);
      if (distance(v) < .5 * radius) inside.push_back(v);
    }
    arap::Options options;
    options.rigidity_radius = .06;
    solver.emplace(mesh.mesh(), options, with_regions(regions));
    for (const int v : extreme_vertices(rest, 0, .1, 3))
      if (regions[v] < 0) task.add(v, rest.row(v).transpose());
    for (const std::vector<int>* of : {&border, &inside}) {
      const arap::Patch patch = solver->patch_around({(*of)[one_of(of->size())]});
      double share = 0;
      double sum = 0;
      for (size_t k = 0; k < patch.vertices.size(); ++k) {
        sum += patch.weights[k];
        if (regions[patch.vertices[k]] >= 0) share += patch.weights[k];
      }
      shares.push_back(share / sum);
      task.add_patch(patch.vertices, patch.weights, patch.rest_position);
    }
    solver->set_constraints(task.constraints);
  }

  Positions moved(const Vector3& first, const Vector3& second) const {
    Positions targets = task.targets;
    targets.row(targets.rows() - 2) += first.transpose();
    targets.row(targets.rows() - 1) += second.transpose();
    return targets;
  }
};

/// By how much an edge has become longer than at rest.
double greatest_stretch(const MeshData& mesh, const Positions& positions) {
  double stretch = 0;
  for (const std::vector<int>& face : mesh.faces)
    for (size_t k = 0; k < face.size(); ++k) {
      const int a = face[k];
      const int b = face[(k + 1) % face.size()];
      const double length = (mesh.vertices[a] - mesh.vertices[b]).norm();
      stretch = std::max(stretch, (positions.row(a) - positions.row(b)).norm() - length);
    }
  return stretch;
}

TEST(RigidRegion, WithPatchesAtItsBorderStayAtRestAndFollowThemWithoutARiseOfTheEnergy) {
  int n_mixed = 0;
  int n_mostly_inside = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    TwoPatches scene(seed);
    n_mixed += scene.shares[0] > .02 && scene.shares[0] < .5 ? 1 : 0;
    n_mostly_inside += scene.shares[0] > .5 && scene.shares[0] < .99 ? 1 : 0;
    const Positions rest = scene.mesh.positions();
    const double size = scene.mesh.diagonal();
    for (int n = 0; n < 4; ++n) {
      const SolveResult result = scene.solver->solve(scene.task.targets, iterations(20, InitialGuess::kPrevious));
      EXPECT_LT(max_distance(result.positions, rest), 1e-6 * size) << "seed " << seed << ", solve " << n;
    }
    Random random(seed);
    const Vector3 step = random.vector(.05 * size);
    for (const Vector3& second : {step, Vector3(Vector3::Zero())}) {
      const Course course = follow(*scene.solver, scene.moved(step, second));
      EXPECT_FALSE(course.has_risen) << "seed " << seed << ", share " << scene.shares[0];
      EXPECT_TRUE(course.has_converged) << "seed " << seed << ", share " << scene.shares[0];
      EXPECT_LT(greatest_stretch(scene.mesh, course.end), 3 * step.norm())
          << "seed " << seed << ", share " << scene.shares[0] << ": no spike";
    }
  }
  EXPECT_GT(n_mixed, 3);
  EXPECT_GT(n_mostly_inside, 3);
}

TEST(RigidRegion, PatchMostlyInARegionIsCarriedByIt) {
  const MeshData mesh = long_bar();
  const std::vector<int> regions = middle_region();
  const std::vector<int> inside = members(regions, 0);
  const int outside = static_cast<int>(
      std::find_if(mesh.vertices.begin(), mesh.vertices.end(), [](const Vector3& p) { return p.x() > .9; }) -
      mesh.vertices.begin());
  const std::vector<int> patch = {inside[0], inside[7], outside};
  const std::vector<double> weights = {.4, .3, .3};
  const Vector3 at_rest = .4 * mesh.vertices[inside[0]] + .3 * mesh.vertices[inside[7]] + .3 * mesh.vertices[outside];
  Task task = bar_task();
  const Vector3 target = at_rest + Vector3(0, .2, .4);
  task.add_patch(patch, weights, target);
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-10), {}, with_regions(regions));
  const RigidMotion motion = best_rigid_motion(rows(mesh.positions(), inside), rows(result.positions, inside));
  EXPECT_LT((motion.apply(at_rest) - target).norm(), 1e-9 * mesh.diagonal());
  // Before the first solve handles are compared with rest: there nothing may turn.
  Task still = hold(mesh, {0});
  still.add_patch(patch, weights, at_rest);
  const SolveResult rest =
      solve_once(mesh, still, iterations(3, InitialGuess::kHandleRotations), {}, with_regions(regions));
  EXPECT_LT(max_distance(rest.positions, mesh.positions()), 1e-9 * mesh.diagonal());
}

}  // namespace
}  // namespace arap_test
