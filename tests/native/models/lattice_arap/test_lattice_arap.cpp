// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/lattice_arap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "arap/error.h"
#include "arap/surface_arap.h"
#include "models/lattice_arap/rods.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::LatticeArap;
using arap::LatticeOptions;
using arap::SolveOptions;
using arap::SolveResult;

/// Both ends held; the upper one is moved by `motion` in `n_steps`.
SolveResult pose_rod(const MeshData& mesh, const std::function<RigidMotion(double)>& motion,
                     const LatticeOptions& options, int n_steps = 6) {
  constexpr double kHeld = 0.4;
  Task task;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][2]) > 3 - kHeld) task.add(v, mesh.vertices[v]);
  LatticeArap solver(mesh.mesh(), options);
  solver.set_constraints(task.constraints);
  SolveResult result;
  for (int step = 1; step <= n_steps; ++step) {
    Positions targets = task.targets;
    for (size_t k = 0; k < task.constraints.vertices.size(); ++k)
      if (targets(static_cast<int>(k), 2) > 0)
        targets.row(static_cast<int>(k)) = motion(static_cast<double>(step) / n_steps)
                                               .apply(Vector3(task.targets.row(static_cast<int>(k))))
                                               .transpose();
    result = solver.solve(targets, to_accuracy(1e-6));
  }
  return result;
}

TEST(LatticeArap, RestsAndMovesRigidly) {
  for (const MeshData& mesh : all_small_meshes()) {
    if (mesh.mesh().n_parts() != 1) continue;
    const std::vector<int> low = extreme_vertices(mesh.positions(), longest_axis(mesh.positions()), .3, 3);
    const Task rest = hold(mesh, low);
    EXPECT_LT(furthest(solve_once(mesh, rest).positions, mesh.positions()), 1e-6 * mesh.diagonal()) << mesh.name;
    const RigidMotion motion = Random(9).rigid_motion(1, .5);
    const Task moved = rigid_task(mesh, rest.constraints, motion);
    EXPECT_LT(furthest(solve_once(mesh, moved).positions, motion.apply(mesh.positions())), 1e-4 * mesh.diagonal())
        << mesh.name;
  }
}

/// Its inner wall keeps its distance from the outer one, however thin it is between them.
TEST(LatticeArap, AHollowRodIsOnePart) {
  const MeshData outer = rod();
  for (const double share : {.5, .8, .98, .999}) {
    MeshData inner = transformed(outer, [&](const Vector3& x) { return Vector3(share * x); });
    for (std::vector<int>& face : inner.faces) std::reverse(face.begin(), face.end());
    const MeshData mesh = join(outer, inner);
    const Task task = bend_task(outer, default_bend(outer));
    LatticeArap solver(mesh.mesh(), coarse());
    EXPECT_EQ(solver.n_parts(), 1);
    EXPECT_EQ(*std::ranges::max_element(solver.part_of_vertex()), 0);
    solver.set_constraints(task.constraints);
    const SolveResult result = solver.solve(task.targets, to_accuracy(1e-6));
    EXPECT_TRUE(result.parts_at_rest.empty());
    double least = 1;
    double most = 1;
    for (int v = 0; v < outer.n_vertices(); ++v) {
      constexpr double kOfACube = .02;
      const double at_rest = (1 - share) * outer.vertices[v].norm();
      const double now = (result.positions.row(v) - result.positions.row(outer.n_vertices() + v)).norm();
      least = std::min(least, (now + kOfACube) / (at_rest + kOfACube));
      most = std::max(most, (now + kOfACube) / (at_rest + kOfACube));
    }
    EXPECT_GT(least, .5) << share;
    EXPECT_LT(most, 2) << share;
  }
}

/// A void counts with its shell, with its seams joined too: there it is one with it only where both are closed.
TEST(LatticeArap, TellsHowManyPartsThereWouldBeWithSeamsJoined) {
  MeshData inner = transformed(icosphere(1), [](const Vector3& x) { return Vector3(.6 * x); });
  for (std::vector<int>& face : inner.faces) std::reverse(face.begin(), face.end());
  const MeshData hollow = join(icosphere(1), inner);
  MeshData torn;
  for (const std::vector<int>& face : hollow.faces) {
    torn.faces.emplace_back();
    for (const int v : face) {
      torn.faces.back().push_back(torn.n_vertices());
      torn.add_vertex(hollow.vertices[v]);
    }
  }
  for (const MeshData& mesh : {hollow, torn}) {
    EXPECT_EQ(LatticeArap::n_parts_joined(mesh.mesh(), 2), 1);
    LatticeOptions options = coarse();
    options.join_seams = true;
    EXPECT_EQ(LatticeArap(mesh.mesh(), options).n_parts(), 1);
  }
  EXPECT_EQ(LatticeArap::n_parts_joined(two_spheres(1).mesh()), 2);
}

TEST(LatticeArap, HardVerticesAreAtTheirTargets) {
  const MeshData mesh = bumpy_sphere(3);
  Task task = hold(mesh, extreme_vertices(mesh.positions(), 0, .2));
  for (const int v : extreme_vertices(mesh.positions(), 0, -.05)) task.add(v, mesh.vertices[v] + Vector3(.3, .5, .1));
  const SolveResult result = solve_once(mesh, task);
  EXPECT_LT(furthest(values_of(task.constraints, result.positions), task.targets), 1e-12);
}

/// The lattice alone brings a rigid handle to a thousandth of the size, so what is spread over its rim is as little.
TEST(LatticeArap, WhatIsNextToAHandleFollowsIt) {
  const MeshData mesh = rod();
  const SolveResult result = pose_rod(mesh, twist, coarse());
  for (const std::vector<int>& face : mesh.faces)
    for (size_t k = 0; k < face.size(); ++k) {
      const int a = face[k];
      const int b = face[(k + 1) % face.size()];
      const double stretch = (result.positions.row(a) - result.positions.row(b)).norm() /
                             (mesh.positions().row(a) - mesh.positions().row(b)).norm();
      EXPECT_GT(stretch, 0.6);
      EXPECT_LT(stretch, 1.6);
    }
}

/// Figures of solid volumes: a surface model alone has .89 and .75 here.
TEST(LatticeArap, ATwistedRodKeepsItsVolume) {
  const MeshData mesh = rod();
  LatticeOptions options;
  options.cube_size = .25 / mesh.diagonal();
  const SolveResult free = pose_rod(mesh, twist, options);
  EXPECT_GT(volume(mesh, free.positions) / volume(mesh, mesh.positions()), .955);
  EXPECT_GT(thinnest(mesh, free.positions), .94);
  options.keep_volume = 1;
  const SolveResult kept = pose_rod(mesh, twist, options);
  EXPECT_GT(volume(mesh, kept.positions) / volume(mesh, mesh.positions()), .992);
  EXPECT_GT(thinnest(mesh, kept.positions), .99);
}

/// The forces of a torn pose must not be carried from step to step.
TEST(LatticeArap, ABentRodKeepsItsVolume) {
  const MeshData mesh = rod();
  LatticeOptions options;
  options.cube_size = .25 / mesh.diagonal();
  options.keep_volume = 1;
  const SolveResult result = pose_rod(
      mesh,
      [](double part) {
        // The middle line becomes an arc of the same length.
        const double angle = part * 2.0944;
        const double radius = 5.2 / angle;
        const Matrix3 turn = rotation_about(Vector3(1, 0, 0), -angle);
        const Vector3 end(0, radius * (1 - std::cos(angle)), radius * std::sin(angle) - 2.6);
        return RigidMotion{turn, end - turn * Vector3(0, 0, 2.6)};
      },
      options);
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  EXPECT_GT(volume(mesh, result.positions) / volume(mesh, mesh.positions()), .996);
  EXPECT_GT(thinnest(mesh, result.positions), .994);
}

TEST(LatticeArap, StartsWithTheTurnsOfItsHandles) {
  const MeshData mesh = rod();
  Task held;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][2]) > 2.6) held.add(v, mesh.vertices[v]);
  const RigidMotion motion{rotation_about(Vector3(1, 2, 3), 2.6), Vector3(1, 0, 2)};
  const Task task = rigid_task(mesh, held.constraints, motion);
  for (const auto guess : {arap::InitialGuess::kPrevious, arap::InitialGuess::kHandleRotations}) {
    LatticeArap solver(mesh.mesh(), coarse());
    solver.set_constraints(task.constraints);
    EXPECT_LT(furthest(solver.solve(task.targets, iterations(1, guess)).positions, motion.apply(mesh.positions())),
              1e-4 * mesh.diagonal());
  }
}

/// Both ends by 150 degrees against each other: 300 together, not 60 the other way round.
TEST(LatticeArap, OneLargeTurnEndsWhereManySmallOnesDo) {
  const MeshData mesh = rod();
  const auto pose = [&](int n_steps, arap::InitialGuess guess) {
    Task task;
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (std::abs(mesh.vertices[v][2]) > 2.6) task.add(v, mesh.vertices[v]);
    LatticeArap solver(mesh.mesh(), coarse());
    solver.set_constraints(task.constraints);
    SolveOptions options = to_accuracy(1e-6);
    options.initial_guess = guess;
    SolveResult result;
    for (int step = 1; step <= n_steps; ++step) {
      Positions targets = task.targets;
      for (Eigen::Index k = 0; k < targets.rows(); ++k) {
        const double angle = 150 * 3.14159265 / 180 * step / n_steps * (targets(k, 2) > 0 ? 1 : -1);
        targets.row(k) = (rotation_about(Vector3(0, 0, 1), angle) * Vector3(targets.row(k))).transpose();
      }
      result = solver.solve(targets, options);
    }
    return result;
  };
  const double in_steps = pose(10, arap::InitialGuess::kPrevious).energy_after;
  for (const auto guess : {arap::InitialGuess::kPrevious, arap::InitialGuess::kHandleRotations})
    EXPECT_NEAR(pose(1, guess).energy_after, in_steps, 1e-3 * in_steps);
}

/// A hill as wide as the lattice makes it, not a spike as narrow as the area of a vertex.
TEST(LatticeArap, ASingleVertexPullsTheSameHillAtEveryDensity) {
  const MeshData coarse_mesh = icosphere(3);
  const MeshData fine = subdivide(subdivide(coarse_mesh));
  const auto pull = [](const MeshData& mesh) {
    Task task;
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (mesh.vertices[v][2] < -.5) task.add(v, mesh.vertices[v]);
    const int tip = extreme_vertices(mesh.positions(), 2, -1e-9).front();
    task.add(tip, mesh.vertices[tip] + Vector3(0, 0, .6));
    return solve_once(mesh, task).positions;
  };
  const Positions of_fine = pull(fine).topRows(coarse_mesh.n_vertices());
  EXPECT_LT(furthest(of_fine, pull(coarse_mesh)), .01 * coarse_mesh.diagonal());
}

TEST(LatticeArap, DoesNotDependOnTheDensityOfTheMesh) {
  MeshData coarse = triangulate(rod(16, 48));
  const MeshData fine = subdivide(coarse);
  Task held;
  LatticeOptions options;
  options.cube_size = .04;
  const auto at = [&](const MeshData& mesh) { return pose_rod(mesh, twist, options, 3).positions; };
  // Vertices of the coarse one are the first of the fine one.
  const Positions of_coarse = at(coarse);
  const Positions of_fine = at(fine).topRows(coarse.n_vertices());
  EXPECT_LT(std::sqrt((of_coarse - of_fine).rowwise().squaredNorm().mean()), 1e-3 * coarse.diagonal());
}

TEST(LatticeArap, PartsWithoutConstraintsStayAtRestEvenIfTheyOverlap) {
  const MeshData ball = icosphere(2);
  const MeshData mesh = join(ball, transformed(ball, [](const Vector3& x) { return Vector3(x + Vector3(1, 0, 0)); }));
  Task task = hold(mesh, {0, 1, 2});
  task.add(40, mesh.vertices[40] + Vector3(.5, .5, 0));
  const SolveResult result = solve_once(mesh, task);
  EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
  const int n = ball.n_vertices();
  EXPECT_LT(furthest(result.positions.bottomRows(n), mesh.positions().bottomRows(n)), 1e-6);
}

TEST(LatticeArap, CubesGoWithTheMesh) {
  const MeshData mesh = rod(12, 36);
  const Task held = hold(mesh, extreme_vertices(mesh.positions(), 2, .2));
  const RigidMotion motion = Random(4).rigid_motion(1, 5);
  const Task task = rigid_task(mesh, held.constraints, motion);
  LatticeArap solver(mesh.mesh(), coarse());
  const Positions rest = solver.cube_corners();
  EXPECT_NEAR((rest.row(7) - rest.row(0)).norm(), std::sqrt(3.0) * solver.cube_size(), 1e-9);
  EXPECT_NEAR((rest.row(1) - rest.row(0))[2], solver.cube_size(), 1e-9);
  solver.set_constraints(task.constraints);
  solver.solve(task.targets, to_accuracy(1e-7));
  const Positions moved = solver.cube_corners();
  ASSERT_EQ(moved.rows(), rest.rows());
  for (int k = 0; k < static_cast<int>(rest.rows()); ++k)
    EXPECT_LT((moved.row(k).transpose() - motion.apply(Vector3(rest.row(k)))).norm(), 1e-4 * mesh.diagonal());
}

TEST(LatticeArap, ASoftVertexGivesWay) {
  const MeshData mesh = bumpy_sphere(2);
  const Vector3 pull(0, 0, 1);
  const int tip = extreme_vertices(mesh.positions(), 2, -1e-9).front();
  double before = 0;
  for (const double strength : {.05, .5, .95, 1.0}) {
    Task task = hold(mesh, extreme_vertices(mesh.positions(), 2, .2));
    task.add(tip, mesh.vertices[tip] + pull, strength);
    const double way = (solve_once(mesh, task).positions.row(tip).transpose() - mesh.vertices[tip])[2];
    EXPECT_GT(way, before);
    before = way;
  }
  EXPECT_NEAR(before, 1, 1e-12);
}

TEST(LatticeArap, APatchMovesItsAverage) {
  const MeshData mesh = bumpy_sphere(3);
  arap::SurfaceArap surface(mesh.mesh());
  const arap::Patch patch = surface.patch_around({extreme_vertices(mesh.positions(), 2, -1e-9).front()}, .1);
  Task task = hold(mesh, extreme_vertices(mesh.positions(), 2, .2));
  task.add_patch(patch.vertices, patch.weights, patch.rest_position + Vector3(.2, 0, .3));
  const SolveResult result = solve_once(mesh, task);
  EXPECT_LT(furthest(values_of(task.constraints, result.positions).bottomRows(1), task.targets.bottomRows(1)), 1e-4);
}

TEST(LatticeArap, JoinedSeamsStayClosed) {
  const int n_along = 20;
  const MeshData mesh = cylinder_with_open_seam(24, n_along, Faces::kQuads);
  LatticeOptions options = coarse();
  options.join_seams = true;
  const SolveResult result = solve_once(mesh, bend_task(mesh, default_bend(mesh)), options);
  const std::vector<int> same = mesh.mesh().same_places();
  for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(result.positions.row(v), result.positions.row(same[v]));
}

TEST(LatticeArap, IsTheSameOnEveryNumberOfThreads) {
  const MeshData mesh = bumpy_sphere(4);
  const Task task = bend_task(mesh, default_bend(mesh));
  LatticeOptions options = coarse();
  options.cube_size = .03;
  options.threads = 1;
  const Positions one = solve_once(mesh, task, options).positions;
  for (const int threads : {2, 3}) {
    options.threads = threads;
    EXPECT_LT(furthest(solve_once(mesh, task, options).positions, one), 1e-5 * mesh.diagonal()) << threads;
  }
}

TEST(LatticeArap, ResetGoesBackToRest) {
  const MeshData mesh = cylinder(16, 8);
  const Task task = bend_task(mesh, default_bend(mesh));
  LatticeArap solver(mesh.mesh(), coarse());
  solver.set_constraints(task.constraints);
  const Positions first = solver.solve(task.targets, to_accuracy(1e-6)).positions;
  solver.reset();
  EXPECT_LT(furthest(solver.solve(task.targets, to_accuracy(1e-6)).positions, first), 1e-4 * mesh.diagonal());
}

TEST(LatticeArap, ACancelledSolveReturnsTheFormerPose) {
  const MeshData mesh = cylinder(16, 8);
  const Task task = bend_task(mesh, default_bend(mesh));
  LatticeArap solver(mesh.mesh(), coarse());
  solver.set_constraints(task.constraints);
  const Positions first = solver.solve(task.targets, to_accuracy(1e-6)).positions;
  Positions further = task.targets;
  further.bottomRows(1).array() += .2;
  const SolveResult cancelled = solver.solve(further, to_accuracy(1e-6), {}, [](double) { return false; });
  EXPECT_EQ(cancelled.stop_reason, arap::StopReason::kCancelled);
  EXPECT_EQ(cancelled.positions, first);
}

TEST(LatticeArap, APatchMayNameALooseVertexWithoutWeight) {
  MeshData mesh = cylinder(16, 8);
  const int loose = mesh.add_vertex({5, 5, 5});
  Task task = hold(mesh, extreme_vertices(mesh.positions(), 2, .2));
  task.add_patch({100, 101, loose}, {1, 1, 0}, mesh.vertices[100] + Vector3(.1, 0, 0));
  EXPECT_TRUE(solve_once(mesh, task).positions.allFinite());
}

TEST(LatticeArap, HardVerticesAtOnePlaceAreAtTheirTargets) {
  MeshData mesh = cylinder(16, 8);
  const int twin = mesh.add_vertex(mesh.vertices[5]);
  mesh.faces.push_back({5, twin, 4});
  const Vector3 of_twin = mesh.vertices[5] + Vector3(.1, .2, .3);
  const Vector3 of_other = mesh.vertices[5] + Vector3(.3, .2, .1);
  Task task;
  task.add(twin, of_twin);
  task.add(5, of_other);
  const Positions points = solve_once(mesh, task).positions;
  EXPECT_LT((points.row(twin).transpose() - of_twin).norm(), 1e-12);
  EXPECT_LT((points.row(5).transpose() - of_other).norm(), 1e-12);
}

TEST(LatticeArap, ALooseVertexIsWhereItsTargetIs) {
  MeshData mesh = cylinder(16, 8);
  const int loose = mesh.add_vertex({5, 5, 5});
  const int other = mesh.add_vertex({-5, 5, 5});
  for (const double strength : {1.0, .3}) {
    Task task = hold(mesh, {0, 1, 2});
    task.add(loose, {6, 5, 5}, strength);
    const SolveResult result = solve_once(mesh, task);
    EXPECT_LT((result.positions.row(loose).transpose() - Vector3(6, 5, 5)).norm(), 1e-12);
    EXPECT_LT((result.positions.row(other).transpose() - mesh.vertices[other]).norm(), 1e-12);
    EXPECT_EQ(result.loose_vertices, (std::vector<int>{loose, other}));
  }
}

// Faces that share all corners are pieces of their own in each cube that they cross.
TEST(LatticeArap, HasLargerCubesIfManyPiecesShareThem) {
  const auto triangle = [](int n_times) {
    return LatticeArap(
        MeshData{"triangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector(n_times, std::vector{0, 1, 2})}.mesh());
  };
  const LatticeArap once = triangle(1);
  const LatticeArap often = triangle(200);
  EXPECT_GT(often.cube_size(), 1.2 * once.cube_size());
  EXPECT_LT(often.n_control_points(), 100 * once.n_control_points());
}

TEST(LatticeArapErrors, SayWhatIsWrong) {
  const MeshData mesh = cylinder(16, 8);
  const auto with = [&](double cube_size, int threads, double keep_volume = 0) {
    LatticeOptions options;
    options.cube_size = cube_size;
    options.keep_volume = keep_volume;
    options.threads = threads;
    return LatticeArap(mesh.mesh(), options);
  };
  expect_error<arap::InvalidInput>([&] { with(2, 0); }, {"cube_size", "2", "0.001"});
  expect_error<arap::InvalidInput>([&] { with(std::nan(""), 0); }, {"cube_size", "nan"});
  expect_error<arap::InvalidInput>([&] { with(.001, 0); }, {"cube_size", "too many"});
  expect_error<arap::InvalidInput>([&] { with(0, -1); }, {"threads", "-1"});
  expect_error<arap::InvalidInput>([&] { with(0, 0, 1.5); }, {"keep_volume", "1.5"});
  expect_error<arap::InvalidInput>([&] { with(0, 0, std::nan("")); }, {"keep_volume", "nan"});
  MeshData points;
  points.add_vertex({0, 0, 0});
  expect_error<arap::InvalidInput>([&] { LatticeArap solver(points.mesh()); }, {"no faces"});
  LatticeArap solver(mesh.mesh());
  expect_error<arap::InvalidInput>([&] { static_cast<void>(solver.solve(Positions::Zero(1, 3))); }, {"constrained"});
}

/// Triangles between any vertices, which cross each other, repeat and are turned either way.
TEST(LatticeArap, PosesAnyMesh) {
  Random random(21);
  for (int round = 0; round < 40; ++round) {
    const auto n = static_cast<int>(random.uniform(3, 40));
    const auto any = [&] { return static_cast<int>(random.uniform(0, n)); };
    MeshData mesh{"soup", {}, {}};
    const double flat = round % 3 == 0 ? 0 : 1;  // all in one plane
    for (int v = 0; v < n; ++v) mesh.add_vertex(random.vector(1).cwiseProduct(Vector3(1, 1, flat)));
    for (int f = 0; f < n; ++f) {
      const int a = any();
      const int b = any();
      mesh.faces.push_back({a, (a + 1 + b % (n - 1)) % n, any()});
    }
    std::erase_if(mesh.faces, [](const std::vector<int>& face) { return face[2] == face[0] || face[2] == face[1]; });
    if (mesh.faces.empty()) continue;
    Task task;
    for (int k = 0; k < std::min(n, 4); ++k) task.add(k, random.vector(2), k == 0 ? 1 : random.uniform(0.01, 1));
    LatticeArap solver(mesh.mesh(), coarse());
    solver.set_constraints(task.constraints);
    const SolveResult result = solver.solve(task.targets, iterations(20));
    EXPECT_TRUE(result.positions.allFinite()) << round;
    EXPECT_LT((result.positions.row(0) - task.targets.row(0)).norm(), 1e-12) << round;
  }
}

/// A pose of the lattice, given as positions alone, is found again: the next iteration moves hardly anything.
TEST(LatticeArap, GoesOnFromGivenPositions) {
  const MeshData mesh = rod();
  const SolveResult posed = pose_rod(mesh, twist, coarse());
  Task task;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][2]) > 2.6) task.add(v, Vector3(posed.positions.row(v)));
  LatticeArap solver(mesh.mesh(), coarse());
  solver.set_constraints(task.constraints);
  solver.set_positions(posed.positions);
  EXPECT_EQ(solver.positions(), posed.positions);
  const SolveResult next = solver.solve(task.targets, iterations(1));
  EXPECT_LT(furthest(next.positions, posed.positions), 3e-3 * mesh.diagonal());
  EXPECT_LT(next.energy_after, 1.01 * posed.energy_after);
  // Half a turn started from rest would go the other way, or stay behind.
  EXPECT_LT(furthest(solver.solve(task.targets, to_accuracy(1e-6)).positions, posed.positions), 1e-3 * mesh.diagonal());
}

TEST(LatticeArap, PositionsOfARigidMotionStartThere) {
  for (const MeshData& mesh : all_small_meshes()) {
    if (mesh.mesh().n_parts() != 1) continue;
    const RigidMotion motion = Random(3).rigid_motion(1, 2);
    const Task held = hold(mesh, extreme_vertices(mesh.positions(), longest_axis(mesh.positions()), .3, 3));
    const Task task = rigid_task(mesh, held.constraints, motion);
    LatticeArap solver(mesh.mesh(), coarse());
    solver.set_constraints(task.constraints);
    solver.set_positions(motion.apply(mesh.positions()));
    EXPECT_LT(furthest(solver.solve(task.targets, iterations(1)).positions, motion.apply(mesh.positions())),
              1e-3 * mesh.diagonal())
        << mesh.name;
  }
}

TEST(LatticeArap, WritesPositionsInSinglePrecision) {
  const MeshData mesh = cylinder(16, 8);
  const Task task = bend_task(mesh, default_bend(mesh));
  LatticeArap solver(mesh.mesh(), coarse());
  solver.set_constraints(task.constraints);
  std::vector<float> out(3 * static_cast<size_t>(mesh.n_vertices()));
  EXPECT_EQ(solver.solve(task.targets, to_accuracy(1e-6), {}, {}, out).positions.rows(), 0);
  const Positions& shown = solver.positions();
  for (int k = 0; k < 3 * mesh.n_vertices(); ++k) EXPECT_EQ(out[k], static_cast<float>(shown.data()[k]));
  const std::vector<float> before = out;
  Positions far = task.targets;
  far.array() += 1e50;
  EXPECT_THROW(solver.solve(far, to_accuracy(1e-6), {}, {}, out), arap::SolverError);
  EXPECT_EQ(out, before);
}

/// The middle of a rod that is bent, as one body: each distance in it stays, and its rim is smooth.
TEST(LatticeArap, ARigidRegionIsExactlyRigid) {
  const MeshData mesh = rod();
  std::vector<int> regions(mesh.n_vertices(), -1);
  std::vector<int> members;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][2]) < .8) {
      regions[v] = 7;
      members.push_back(v);
    }
  Task task;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][2]) > 2.6) task.add(v, mesh.vertices[v]);
  for (Eigen::Index k = 0; k < task.targets.rows(); ++k)
    if (task.targets(k, 2) > 0)
      task.targets.row(k) = (rotation_about(Vector3(1, 0, 0), 1.2) * Vector3(task.targets.row(k))).transpose();
  LatticeArap solver(mesh.mesh(), coarse(), with_regions(regions));
  solver.set_constraints(task.constraints);
  const Positions points = solver.solve(task.targets, to_accuracy(1e-6)).positions;
  for (const int a : members)
    for (const int b : {members.front(), members.back()})
      EXPECT_NEAR((points.row(a) - points.row(b)).norm(), (mesh.positions().row(a) - mesh.positions().row(b)).norm(),
                  1e-12);
  EXPECT_GT((points.row(members[0]) - mesh.positions().row(members[0])).norm(), .1);
  EXPECT_LT(furthest(values_of(task.constraints, points), task.targets), 1e-12);
}

/// Two of its vertices are held: it turns about them as the lattice does, and stays one body.
TEST(LatticeArap, ARigidRegionGoesWithItsHardVertices) {
  const MeshData mesh = bumpy_sphere(3);
  std::vector<int> regions(mesh.n_vertices(), -1);
  for (const int v : extreme_vertices(mesh.positions(), 2, -.3)) regions[v] = 0;
  const std::vector<int> held = extreme_vertices(mesh.positions(), 2, -.02);
  Task task = hold(mesh, extreme_vertices(mesh.positions(), 2, .2));
  for (const int v : held) task.add(v, mesh.vertices[v] + Vector3(.2, .1, .3));
  LatticeArap solver(mesh.mesh(), coarse(), with_regions(regions));
  solver.set_constraints(task.constraints);
  const Positions points = solver.solve(task.targets, to_accuracy(1e-6)).positions;
  EXPECT_LT(furthest(values_of(task.constraints, points), task.targets), 1e-6);
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (regions[v] < 0) continue;
    EXPECT_NEAR((points.row(v) - points.row(held.front())).norm(),
                (mesh.positions().row(v) - mesh.positions().row(held.front())).norm(), 1e-6);
  }
}

/// Of a rod that is bent, the half with a hundred times the stiffness stays nearly straight.
TEST(LatticeArap, AStiffHalfBendsLess) {
  const MeshData mesh = rod();
  arap::VertexProperties properties;
  for (int v = 0; v < mesh.n_vertices(); ++v) properties.stiffness.push_back(mesh.vertices[v][2] > 0 ? 100 : 1);
  Task task;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][2]) > 2.6) task.add(v, mesh.vertices[v]);
  for (Eigen::Index k = 0; k < task.targets.rows(); ++k)
    if (task.targets(k, 2) > 0)
      task.targets.row(k) = (rotation_about(Vector3(1, 0, 0), 1) * Vector3(task.targets.row(k))).transpose();
  LatticeArap solver(mesh.mesh(), coarse(), properties);
  solver.set_constraints(task.constraints);
  const Positions points = solver.solve(task.targets, to_accuracy(1e-6)).positions;
  const auto change = [&](bool of_stiff) {
    double sum = 0;
    for (const std::vector<int>& face : mesh.faces)
      for (size_t k = 0; k < face.size(); ++k) {
        const int a = face[k];
        const int b = face[(k + 1) % face.size()];
        if ((mesh.vertices[a][2] > .5) != of_stiff || std::abs(mesh.vertices[a][2]) < .5) continue;
        sum += std::abs(
            (points.row(a) - points.row(b)).norm() / (mesh.positions().row(a) - mesh.positions().row(b)).norm() - 1);
      }
    return sum;
  };
  EXPECT_LT(change(true), .3 * change(false));
}

TEST(LatticeArap, ACancelledBindStops) {
  EXPECT_THROW(LatticeArap(rod().mesh(), {}, {}, [](double) { return false; }), arap::Cancelled);
}

}  // namespace
}  // namespace arap_test
