// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InitialGuess;
using arap::SolveResult;
using arap::SurfaceArap;

class InitialGuessTest : public OfEachModel {};

TEST_P(InitialGuessTest, RestStartsAtRestWithHardVerticesAtTheirTargets) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  const Reference plain = reference(mesh);
  SurfaceArap solver(mesh.mesh(), options());
  solver.set_constraints(task.constraints);
  solver.set_positions(Random(41).noise(mesh.n_vertices(), 2));
  const double expected = plain.energy(plain.rest_guess(task.constraints, task.targets));
  EXPECT_NEAR(solver.solve(task.targets, iterations(1, InitialGuess::kRest)).energy_before, expected, 1e-10 * expected);
}

TEST_P(InitialGuessTest, PreviousTakesPositionsThatWereSet) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  const Reference plain = reference(mesh);
  SurfaceArap solver(mesh.mesh(), exactly(options()));
  solver.set_constraints(task.constraints);
  Positions start = mesh.positions() + Random(42).noise(mesh.n_vertices(), .1);
  for (size_t k = 0; k < task.constraints.vertices.size(); ++k)
    start.row(task.constraints.vertices[k]) = task.targets.row(static_cast<Eigen::Index>(k));
  solver.set_positions(start);
  const Reference::Solution expected = plain.solve(task.constraints, task.targets, start, 3);
  const SolveResult result = solver.solve(task.targets, plain_iterations(3));
  EXPECT_NEAR(result.energy_before, expected.energies.front(), 1e-10 * expected.energies.front());
  EXPECT_LT(max_distance(result.positions, expected.positions), 1e-8);
}

TEST_P(InitialGuessTest, PreviousIsNotTornByHandlesThatMoved) {
  // The rest follows by one global step with the rotations it had: the start has less energy than the torn one.
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  const SolveResult torn = solve_once(mesh, task, iterations(1, InitialGuess::kRest), options());
  const SolveResult result = solve_once(mesh, task, iterations(1), options());
  EXPECT_LT(result.energy_before, torn.energy_before);
}

TEST_P(InitialGuessTest, NaiveLaplacianKeepsThatOfRestInTheLeastSquaresSense) {
  for (const MeshData& mesh : {bumpy_sphere(1), quad_sphere(2), open_cylinder(8, 4, Faces::kTriangles)}) {
    const Task task = bend_task(mesh, default_bend(mesh));
    const Reference plain = reference(mesh);
    const Reference::Solution expected =
        plain.solve(task.constraints, task.targets, plain.laplacian_guess(task.constraints, task.targets), 2);
    SurfaceArap solver(mesh.mesh(), exactly(options()));
    solver.set_constraints(task.constraints);
    solver.set_positions(Random(43).noise(mesh.n_vertices(), 1));
    const SolveResult result = solver.solve(task.targets, plain_iterations(2, InitialGuess::kNaiveLaplacian));
    EXPECT_NEAR(result.energy_before, expected.energies.front(), 1e-7 * expected.energies.front()) << mesh.name;
    EXPECT_LT(max_distance(result.positions, expected.positions), 1e-7 * mesh.diagonal()) << mesh.name;
  }
}

TEST_P(InitialGuessTest, HandleRotationsOfOneRigidMotionAreThatMotion) {
  Random random(44);
  for (const MeshData& mesh : all_small_meshes()) {
    const RigidMotion motion = random.rigid_motion(2.8, mesh.diagonal());
    const Task task = rigid_task(mesh, bend_task(mesh, {}).constraints, motion);
    SurfaceArap solver(mesh.mesh(), options());
    solver.set_constraints(task.constraints);
    const std::vector<Matrix3> rotations(static_cast<size_t>(task.targets.rows()), motion.rotation);
    const SolveResult given = solver.solve(task.targets, iterations(1, InitialGuess::kHandleRotations), rotations);
    EXPECT_NEAR(given.energy_before, 0, 1e-10 * mesh.diagonal() * mesh.diagonal()) << mesh.name;
    EXPECT_LT(max_distance(given.positions, motion.apply(mesh.positions())), 1e-7 * mesh.diagonal()) << mesh.name;
  }
}

TEST_P(InitialGuessTest, HandleRotationsAreEstimatedFromTheTargets) {
  Random random(45);
  for (const MeshData& mesh : {bumpy_sphere(2), cylinder(10, 6), bar(2, Faces::kQuads), star_prism(5, 3)}) {
    const RigidMotion motion = random.rigid_motion(2.8, mesh.diagonal());
    const Task task = rigid_task(mesh, bend_task(mesh, {}).constraints, motion);
    for (const InitialGuess guess : {InitialGuess::kHandleRotations, InitialGuess::kPrevious}) {
      const SolveResult result = solve_once(mesh, task, iterations(1, guess), options());
      EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-7 * mesh.diagonal()) << mesh.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllModels, InitialGuessTest, testing::ValuesIn(all_models()), model_name);

TEST(HandleRotations, TurnTheMeshBetweenHandlesSmoothly) {
  // A bar twisted by 2 radians: rotations that vary along it start near the answer, rest far away.
  const MeshData mesh = bar(3, Faces::kQuads);
  const Task task = bend_task(mesh, {rotation_about(Vector3::UnitX(), 2), Vector3::Zero()});
  const auto energy_before = [&](InitialGuess guess) {
    return solve_once(mesh, task, iterations(1, guess)).energy_before;
  };
  EXPECT_LT(energy_before(InitialGuess::kHandleRotations), .1 * energy_before(InitialGuess::kRest));
}

TEST(HandleRotations, GivenOnesNeedNotAgreeWithTheTargets) {
  // Two single vertices tell nothing about rotations by themselves.
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, {0, 41});
  const std::vector<Matrix3> turned(2, rotation_about({0, 0, 1}, 1));
  const SolveResult given = [&] {
    SurfaceArap solver(mesh.mesh());
    solver.set_constraints(task.constraints);
    return solver.solve(task.targets, iterations(1, InitialGuess::kHandleRotations), turned);
  }();
  EXPECT_GT(max_distance(given.positions, mesh.positions()), .1 * mesh.diagonal());
  EXPECT_TRUE(given.positions.allFinite());
}

TEST(HandleRotations, GroupsThatTellNoRotationAreFine) {
  const MeshData rest = bar(2, Faces::kQuads);
  MeshData mesh = rest;
  const RigidMotion lift{Matrix3::Identity(), {0, 0, .7}};
  // One vertex; a row of an edge.
  for (const std::vector<int>& group :
       {std::vector<int>{mesh.vertex_at({-2, .5, .5})},
        {mesh.vertex_at({2, .5, .5}), mesh.vertex_at({2, 0, .5}), mesh.vertex_at({2, -.5, .5})}}) {
    ASSERT_EQ(mesh.n_vertices(), rest.n_vertices());
    const Task task = rigid_task(mesh, hold(mesh, group).constraints, lift);
    for (const InitialGuess guess : {InitialGuess::kPrevious, InitialGuess::kHandleRotations})
      EXPECT_LT(
          max_distance(solve_once(mesh, task, iterations(3, guess), exactly()).positions, lift.apply(mesh.positions())),
          1e-9)
          << "a translation asks for no rotation";
  }
}

TEST(HandleRotations, ASingleVertexBesideAGroupTakesTheGroupsRotation) {
  const MeshData mesh = bar(2, Faces::kQuads);
  const RigidMotion motion = Random(46).rigid_motion(2, 1);
  arap::ConstraintSet set;
  for (const int v : extreme_vertices(mesh.positions(), 0, .2)) set.vertices.push_back(v);
  set.vertices.push_back(extreme_vertices(mesh.positions(), 0, -.01).front());
  set.strengths.assign(set.vertices.size(), 1);
  const Task task = rigid_task(mesh, set, motion);
  const SolveResult result = solve_once(mesh, task, iterations(1, InitialGuess::kHandleRotations));
  EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-7);
}

TEST(LargeMoves, OneStepEndsWhereTenSmallOnesDo) {
  const MeshData mesh = bar(3, Faces::kTriangles);
  struct Turn {
    Vector3 axis;
    double angle_rad;
  };
  // Not far in the bar's plane of symmetry: there it buckles to one side or the other.
  const std::vector<Turn> turns = {{Vector3::UnitX(), 1.6},
                                   {Vector3::UnitX(), 2.6},
                                   {Vector3::UnitY(), 1.6},
                                   {Vector3(1, 1, 0), 1.6},
                                   {Vector3(1, 1, 0), 2.6}};
  for (const arap::Energy energy : {arap::Energy::kRotationNodes, arap::Energy::kSpokesAndRims})
    for (const Turn& turn : turns) {
      const auto pose = [&](int n_steps) {
        SurfaceArap solver(mesh.mesh(), Model{energy, arap::EdgeWeights::kCotangent, .1}.options());
        solver.set_constraints(bend_task(mesh, {}).constraints);
        for (int k = 1; k <= n_steps; ++k)
          solver.solve(
              bend_task(mesh, {rotation_about(turn.axis, turn.angle_rad * k / n_steps), Vector3::Zero()}).targets,
              to_accuracy(1e-8));
        return Positions(solver.positions());
      };
      EXPECT_LT(max_distance(pose(1), pose(10)), 1e-4 * mesh.diagonal())
          << "about " << turn.axis.transpose() << " by " << turn.angle_rad;
    }
}

TEST(LargeMoves, OfTwoHandlesAgainstEachOtherTwistByBothAngles) {
  // By 150 degrees each: 300 together, not 60 the other way round.
  const MeshData mesh = bar(2, Faces::kQuads);
  constexpr double kAngle = 150 * std::numbers::pi / 180;
  const auto twist = [&](double part) {
    Task task;
    for (const int end : {-1, 1})
      for (const int v : extreme_vertices(mesh.positions(), 0, -.05 * end))
        task.add(v, rotation_about(Vector3::UnitX(), part * end * kAngle) * mesh.vertices[v]);
    return task;
  };
  SurfaceArap in_steps(mesh.mesh());
  in_steps.set_constraints(twist(1).constraints);
  SolveResult expected;
  for (int k = 1; k <= 20; ++k) expected = in_steps.solve(twist(k / 20.0).targets, to_accuracy(1e-8));
  const SolveResult at_once = solve_once(mesh, twist(1), to_accuracy(1e-8));
  EXPECT_NEAR(at_once.energy_after, expected.energy_after, 1e-6 * expected.energy_after);
}

TEST(LargeMoves, OfOnePartTurnNoOther) {
  const MeshData mesh = two_spheres(1);
  const int n = mesh.n_vertices() / 2;
  Task task;
  for (int v = 0; v < n; ++v) task.add(v, rotation_about(Vector3::UnitZ(), 2) * mesh.vertices[v]);
  task.add(n, mesh.vertices[n] + Vector3::UnitZ());
  const SolveResult result = solve_once(mesh, task, iterations(1));
  Positions lifted = mesh.positions().bottomRows(n);
  lifted.col(2).array() += 1;
  EXPECT_LT(max_distance(result.positions.bottomRows(n), lifted), 1e-7);
}

}  // namespace
}  // namespace arap_test
