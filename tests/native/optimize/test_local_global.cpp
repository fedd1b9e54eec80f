// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <initializer_list>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::EdgeWeights;
using arap::Energy;
using arap::InitialGuess;
using arap::SolveOptions;
using arap::SolveResult;
using arap::StopReason;
using arap::SurfaceArap;

/// So far that the energy is far from quadratic.
RigidMotion hard_bend(const MeshData& mesh) {
  return {rotation_about({1, .4, .2}, 2.5), Vector3(.3, -.2, .3) * mesh.diagonal()};
}

class LocalGlobal : public OfEachModel {};

TEST_P(LocalGlobal, PlainIterationsAreThoseOfTheReference) {
  for (const MeshData& mesh : all_small_meshes()) {
    // There held vertices cut the free ones into two parts, and the reference does not split nodes.
    const bool is_cut = mesh.name == "cube" || mesh.name == "moebius_strip";
    if (GetParam().energy == Energy::kRotationNodes && is_cut) continue;
    const Task task = bend_task(mesh, default_bend(mesh));
    const Reference plain = reference(mesh);
    SurfaceArap solver(mesh.mesh(), exactly(options()));
    solver.set_constraints(task.constraints);
    for (const int n : {1, 2, 5}) {
      const Reference::Solution expected =
          plain.solve(task.constraints, task.targets, plain.rest_guess(task.constraints, task.targets), n);
      const SolveResult result = solver.solve(task.targets, plain_iterations(n, InitialGuess::kRest));
      const double scale = expected.energies.front();
      EXPECT_LT(max_distance(result.positions, expected.positions), 2e-7 * mesh.diagonal()) << mesh.name << ", " << n;
      EXPECT_NEAR(result.energy_before, expected.energies.front(), 1e-9 * scale) << mesh.name;
      EXPECT_NEAR(result.energy_after, expected.energies.back(), 1e-7 * scale) << mesh.name;
      EXPECT_NEAR(result.step, expected.step, 1e-6) << mesh.name;
      EXPECT_EQ(result.iterations, task.constraints.n_targets() < mesh.n_vertices() ? n : 1) << mesh.name;
    }
  }
}

TEST_P(LocalGlobal, AcceleratedIterationsEndBelowPlainOnes) {
  // Plain steps of large stiff pieces come down fast from afar, where the energy is far from quadratic: there the
  // accelerated ones may be behind for a few iterations.
  const bool has_nodes = GetParam().energy == Energy::kRotationNodes;
  const std::vector<int> counts = has_nodes ? std::vector{1, 10, 30} : std::vector{1, 3, 10, 30};
  for (const MeshData& mesh : all_small_meshes()) {
    for (const RigidMotion& bend : {default_bend(mesh), hard_bend(mesh)}) {
      const Task task = bend_task(mesh, bend);
      for (const int n : counts) {
        const double limit = solve_once(mesh, task, plain_iterations(n, InitialGuess::kRest), options()).energy_after;
        const double reached = solve_once(mesh, task, iterations(n, InitialGuess::kRest), options()).energy_after;
        EXPECT_LE(reached, limit * (1 + 1e-9)) << mesh.name << ", " << n << " iterations";
      }
    }
  }
}

TEST_P(LocalGlobal, ConvergesWhereTheReferenceDoes) {
  for (const MeshData& mesh : {bumpy_sphere(1), quad_sphere(2), l_prism(4), open_cylinder(8, 5, Faces::kTriangles),
                               book(3, Faces::kTriangles), sheared_cylinder(8, 4)})
    expect_ends_at_reference(mesh, bend_task(mesh, default_bend(mesh)), GetParam());
}

TEST_P(LocalGlobal, SoftConstraintsConvergeWhereTheReferenceDoes) {
  Random random(31);
  for (const double share : {.7, 1.0})
    for (const MeshData& mesh : {bumpy_sphere(1), l_prism(3)}) {
      Task task = bend_task(mesh, default_bend(mesh));
      for (double& s : task.constraints.strengths)
        if (random.uniform(0, 1) < share) s = random.uniform(.01, .99);
      expect_ends_at_reference(mesh, task, GetParam());
    }
}

TEST_P(LocalGlobal, RandomStiffnessConvergesWhereTheReferenceDoes) {
  Random random(32);
  for (const MeshData& mesh : {bumpy_sphere(1), quad_sphere(2), star_prism(5, 3)}) {
    std::vector<double> stiffness(static_cast<size_t>(mesh.n_vertices()));
    for (double& s : stiffness) s = std::pow(100, random.uniform(0, 1));
    Task task = bend_task(mesh, default_bend(mesh));
    task.constraints.strengths.back() = .5;
    expect_ends_at_reference(mesh, task, GetParam(), stiffness);
  }
}

TEST_P(LocalGlobal, EnergyNeverRises) {
  for (const MeshData& mesh : all_small_meshes()) {
    const Task task = bend_task(mesh, hard_bend(mesh));
    SurfaceArap solver(mesh.mesh(), options());
    solver.set_constraints(task.constraints);
    expect_energy_never_rises(solver, mesh, task.targets, 40, mesh.name);
  }
}

TEST_P(LocalGlobal, EnergyNeverRisesWithSoftConstraintsStiffnessAndPatches) {
  const MeshData mesh = bumpy_sphere(1);
  std::vector<double> stiffness(static_cast<size_t>(mesh.n_vertices()), 1);
  for (size_t v = 0; v < stiffness.size(); v += 2) stiffness[v] = 100;
  Task task = bend_task(mesh, {rotation_about({1, .4, .2}, 2.5), {.5, 0, .5}});
  for (size_t k = 0; k < task.constraints.strengths.size(); k += 2) task.constraints.strengths[k] = .3;
  task.add_patch({0, 5, 9}, {1, 2, 1}, {0, 0, 3});
  SurfaceArap solver(mesh.mesh(), options(), {stiffness, {}});
  solver.set_constraints(task.constraints);
  expect_energy_never_rises(solver, mesh, task.targets, 60, mesh.name);
}

TEST_P(LocalGlobal, EnergyNeverRisesInSinglePrecision) {
  const MeshData mesh = bumpy_sphere(4);
  const Task task = bend_task(mesh, hard_bend(mesh));
  SurfaceArap solver(mesh.mesh(), options());
  solver.set_constraints(task.constraints);
  SolveOptions in_single;
  in_single.accuracy = 1e-4;  // finer ones end in double
  // Single errors of cells average out, those of a few nodes less.
  const double rounding = GetParam().energy == Energy::kRotationNodes ? 1e-7 : 1e-9;
  expect_energy_never_rises(solver, mesh, task.targets, 30, mesh.name, in_single, rounding);
}

INSTANTIATE_TEST_SUITE_P(AllModels, LocalGlobal, testing::ValuesIn(all_models()), model_name);

// Small moves of a whole mesh: from rest, by iteration alone.

TEST(Convergence, AllHandlesMovedByOneRigidMotionMoveTheMeshByIt) {
  Random random(33);
  for (const MeshData& mesh : all_small_meshes()) {
    const RigidMotion motion = random.rigid_motion(.6, .3 * mesh.diagonal());
    const Task task = rigid_task(mesh, bend_task(mesh, {}).constraints, motion);
    for (const Model& model : all_models()) {
      const SolveResult result = solve_once(mesh, task, to_accuracy(1e-9, InitialGuess::kRest), model.options());
      EXPECT_EQ(result.stop_reason, StopReason::kConverged) << mesh.name << model.name();
      EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-6 * mesh.diagonal())
          << mesh.name << model.name() << ", " << result.iterations << " iterations";
    }
  }
}

TEST(Convergence, ThereAndBackEndsAtRest) {
  for (const MeshData& mesh : all_small_meshes()) {
    const Task there = bend_task(mesh, default_bend(mesh));
    const Task back = bend_task(mesh, {});
    for (const Model& model : all_models()) {
      SurfaceArap solver(mesh.mesh(), model.options());
      solver.set_constraints(there.constraints);
      const SolveResult posed = solver.solve(there.targets, to_accuracy(1e-9));
      EXPECT_EQ(posed.stop_reason, StopReason::kConverged) << mesh.name << model.name();
      EXPECT_GT(max_distance(posed.positions, mesh.positions()), .05 * mesh.diagonal()) << mesh.name;
      const SolveResult result = solver.solve(back.targets, to_accuracy(1e-9));
      EXPECT_LT(max_distance(result.positions, mesh.positions()), 1e-4 * mesh.diagonal()) << mesh.name << model.name();
    }
  }
}

TEST(Convergence, RestInRestOut) {
  for (const MeshData& mesh : all_small_meshes()) {
    const Task task = bend_task(mesh, {});
    for (const Model& model : all_models()) {
      for (const InitialGuess guess : {InitialGuess::kPrevious, InitialGuess::kRest, InitialGuess::kNaiveLaplacian,
                                       InitialGuess::kHandleRotations}) {
        const SolveResult result = solve_once(mesh, task, iterations(10, guess), model.options());
        EXPECT_LT(max_distance(result.positions, mesh.positions()), 1e-9 * mesh.diagonal())
            << mesh.name << model.name();
        EXPECT_NEAR(result.energy_after, 0, 1e-12 * mesh.diagonal() * mesh.diagonal()) << mesh.name << model.name();
      }
    }
  }
}

// Why an iteration ended.

TEST(StopReason, ConvergedWhereItIsAsNearToTheEndAsAsked) {
  const MeshData mesh = bumpy_sphere(4);
  const Task task = bend_task(mesh, {rotation_about({1, .4, .2}, 1.5), Vector3(.2, -.1, .2) * mesh.diagonal()});
  for (const Model& model : {all_models()[1], Model{Energy::kRotationNodes, EdgeWeights::kCotangent}}) {
    const Positions end = solve_once(mesh, task, to_accuracy(1e-13), model.options()).positions;
    for (const double accuracy : {1e-3, 1e-5, 1e-6, 1e-7, 1e-9}) {
      const SolveResult result = solve_once(mesh, task, to_accuracy(accuracy), model.options());
      EXPECT_EQ(result.stop_reason, StopReason::kConverged) << model.name();
      EXPECT_LT(max_distance(result.positions, end), accuracy * mesh.diagonal()) << model.name() << ", " << accuracy;
    }
  }
}

TEST(StopReason, ConvergedWithoutAccelerationToo) {
  const MeshData mesh = bar(2, Faces::kTriangles);
  const Task task = bend_task(mesh, default_bend(mesh));
  SolveOptions options = to_accuracy(1e-6);
  options.acceleration = arap::Acceleration::kNone;
  const SolveResult result = solve_once(mesh, task, options);
  EXPECT_EQ(result.stop_reason, StopReason::kConverged);
  EXPECT_LT(max_distance(result.positions, solve_once(mesh, task, to_accuracy(1e-12)).positions),
            1e-6 * mesh.diagonal());
}

TEST(StopReason, MaxIterationsWhenTheyRanOut) {
  const MeshData mesh = bar(2, Faces::kTriangles);
  const Task task = bend_task(mesh, default_bend(mesh));
  for (const int n : {1, 4}) {
    const SolveResult result = solve_once(mesh, task, iterations(n));
    EXPECT_EQ(result.stop_reason, StopReason::kMaxIterations);
    EXPECT_EQ(result.iterations, n);
    EXPECT_GT(result.step, 0);
    EXPECT_LT(result.energy_after, result.energy_before);
  }
}

TEST(StopReason, TimeLimitWhenTimeIsUpAndAtLeastOneIterationIsDone) {
  const MeshData mesh = bar(2, Faces::kTriangles);
  const Task task = bend_task(mesh, default_bend(mesh));
  SolveOptions options = iterations(1000);
  options.time_limit_s = 1e-9;
  const SolveResult result = solve_once(mesh, task, options);
  EXPECT_EQ(result.stop_reason, StopReason::kTimeLimit);
  EXPECT_EQ(result.iterations, 1);
  const SolveResult one = solve_once(mesh, task, iterations(1));
  EXPECT_EQ(result.positions, one.positions) << "what was done by then is kept";
}

TEST(Solve, GoesOnAsIfThereHadBeenNoEnd) {
  for (const Model& model : all_models()) {
    const MeshData mesh = bar(4, Faces::kTriangles);
    Task task = bend_task(mesh, default_bend(mesh));
    for (size_t k = 0; k < task.constraints.strengths.size(); k += 2) task.constraints.strengths[k] = .2;
    const int middle = extreme_vertices(mesh.positions(), 0, .5).back();
    task.add_patch({middle, middle + 1}, {1, 2}, mesh.vertices[middle] + Vector3(0, .1, .2));
    const auto solve_in = [&](std::initializer_list<int> pieces) {
      SurfaceArap solver(mesh.mesh(), model.options());
      solver.set_constraints(task.constraints);
      SolveResult result;
      for (const int n : pieces) result = solver.solve(task.targets, iterations(n));
      return result;
    };
    const SolveResult whole = solve_in({12});
    for (const SolveResult& pieces : {solve_in({5, 7}), solve_in({1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1})}) {
      EXPECT_LT((pieces.positions - whole.positions).cwiseAbs().maxCoeff(), 1e-9) << model.name();
      EXPECT_NEAR(pieces.energy_after, whole.energy_after, 1e-9 * whole.energy_after) << model.name();
    }
  }
}

TEST(Solve, AnotherPoseBeginsTheSearchAnew) {
  const MeshData mesh = bar(4, Faces::kTriangles);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  const auto next_from = [&](const Positions& positions) {
    solver.set_positions(positions);
    return solver.solve(task.targets, iterations(2)).positions;
  };
  const Positions start = solver.solve(task.targets, iterations(3)).positions;
  const Positions next = next_from(start);
  static_cast<void>(solver.solve(task.targets, iterations(4)));
  EXPECT_EQ(next_from(start), next) << "what came in between is forgotten";
  const SolveResult cancelled =
      solver.solve(task.targets, iterations(4), {}, [n = 0](double) mutable { return ++n < 3; });
  ASSERT_EQ(cancelled.stop_reason, StopReason::kCancelled);
  EXPECT_EQ(cancelled.positions, next);
  const Positions after = solver.solve(task.targets, iterations(2)).positions;
  EXPECT_LT((after - next_from(next)).cwiseAbs().maxCoeff(), 1e-9) << "and what a cancelled solve did";
}

TEST(StopReason, ConvergedAtOnceWhereNothingIsToDo) {
  const MeshData mesh = bumpy_sphere(1);
  const SolveResult result = solve_once(mesh, hold(mesh, {0, 1, 2}), {});
  EXPECT_EQ(result.stop_reason, StopReason::kConverged) << "also where the energy is 0";
  EXPECT_EQ(result.iterations, 1);
  EXPECT_LT(result.step, 1e-7);
}

TEST(StopReason, ConvergedWhereNoVertexIsFree) {
  const MeshData mesh = cube();
  const RigidMotion motion = Random(34).rigid_motion(1, 2);
  const Task task = rigid_task(mesh, bend_task(mesh, {}).constraints, motion);
  ASSERT_LT(task.constraints.n_targets(), 8);
  Task all;
  for (int v = 0; v < 8; ++v) all.add(v, motion.apply(mesh.vertices[v]));
  const SolveResult result = solve_once(mesh, all, {});
  EXPECT_EQ(result.stop_reason, StopReason::kConverged);
  EXPECT_LT(max_distance(result.positions, all.targets), 1e-14);
  EXPECT_NEAR(result.energy_after, 0, 1e-12);
}

/// A region of what is near the middle of the longest axis.
std::vector<int> rigid_middle(const MeshData& mesh) {
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][longest_axis(mesh.positions())]) < .2) regions[v] = 0;
  return regions;
}

/// A drag of a handle of hard and soft vertices, some of them with the other end. `between` is called before each
/// frame.
template <class Between>
std::vector<SolveResult> drag(const MeshData& mesh, const SolveOptions& options, const Between& between,
                              const std::vector<int>& regions = {}) {
  SurfaceArap solver(mesh.mesh(), {}, with_regions(regions));
  Task task = bend_task(mesh, {});
  for (size_t k = 0; k < task.constraints.strengths.size(); k += 3) task.constraints.strengths[k] = 0.3;
  solver.set_constraints(task.constraints);
  std::vector<SolveResult> frames;
  for (int frame = 1; frame <= 4; ++frame) {
    between(solver);
    const RigidMotion motion{rotation_about({1, .3, .2}, .1 * frame),
                             Vector3(.02, .03, -.01) * frame * mesh.diagonal()};
    frames.push_back(solver.solve(bend_task(mesh, motion).targets, options));
  }
  return frames;
}

TEST(Drag, AFrameGoesOnWhereTheLastOneEndedAsIfItLookedAgain) {
  SolveOptions in_single = iterations(2);
  in_single.accuracy = 1e-7;
  struct Case {
    MeshData mesh;
    SolveOptions options;
    double tolerance;
    std::vector<int> regions = {};
  };
  for (const auto& [mesh, options, tolerance, regions] :
       {Case{bumpy_sphere(4), in_single, 1e-6}, Case{bumpy_sphere(4), iterations(2), 1e-11},
        Case{bumpy_sphere(2), iterations(1), 1e-11},
        Case{bumpy_sphere(4), in_single, 1e-6, rigid_middle(bumpy_sphere(4))},
        Case{bumpy_sphere(2), iterations(1), 1e-11, rigid_middle(bumpy_sphere(2))}}) {
    const std::vector<SolveResult> frames = drag(
        mesh, options, [](SurfaceArap&) {}, regions);
    // Another energy is looked at with what the iteration works with, so the next frame has to begin anew.
    const Positions elsewhere =
        transformed(mesh, [](const Vector3& x) { return Vector3(-x[1], 2 * x[0], x[2]); }).positions();
    const std::vector<SolveResult> expected = drag(
        mesh, options, [&](SurfaceArap& solver) { static_cast<void>(solver.energy(elsewhere)); }, regions);
    for (size_t k = 0; k < frames.size(); ++k) {
      EXPECT_LT(max_distance(frames[k].positions, expected[k].positions), tolerance * mesh.diagonal())
          << mesh.name << ", frame " << k;
      EXPECT_NEAR(frames[k].energy_after, expected[k].energy_after, 10 * tolerance * expected[k].energy_after);
      EXPECT_EQ(frames[k].iterations, expected[k].iterations);
    }
  }
}

TEST(Drag, WhatMovesThePoseBetweenFramesIsSeen) {
  const MeshData mesh = bumpy_sphere(4);
  const Positions bent = solve_once(mesh, bend_task(mesh, default_bend(mesh)), iterations(3)).positions;
  const auto looked_again = [](SurfaceArap& solver) { static_cast<void>(solver.energy(solver.positions())); };
  const auto expect_same = [&](const char* what, const std::function<void(SurfaceArap&)>& change) {
    const std::vector<SolveResult> frames = drag(mesh, iterations(2), change);
    const std::vector<SolveResult> expected = drag(mesh, iterations(2), [&](SurfaceArap& solver) {
      change(solver);
      looked_again(solver);
    });
    for (size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(frames[k].positions, expected[k].positions) << what << k;
  };
  expect_same("reset, frame ", [](SurfaceArap& solver) { solver.reset(); });
  expect_same("set_positions, frame ", [&](SurfaceArap& solver) { solver.set_positions(bent); });
  expect_same("cancelled, frame ", [&](SurfaceArap& solver) {
    const Positions targets = bend_task(mesh, default_bend(mesh)).targets;
    int n_calls = 0;
    static_cast<void>(solver.solve(targets, iterations(9), {}, [&](double) { return ++n_calls < 3; }));
  });
}

}  // namespace
}  // namespace arap_test
