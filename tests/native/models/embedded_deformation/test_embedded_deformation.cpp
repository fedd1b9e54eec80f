// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/embedded_deformation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "arap/error.h"
#include "models/embedded_deformation/deformation_graph.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::EmbeddedDeformation;
using arap::EmbeddedOptions;
using arap::GraphNodes;
using arap::GraphWeights;
using arap::InvalidInput;
using arap::SolveResult;

EmbeddedOptions with_distance(double distance, GraphNodes nodes = GraphNodes::kAffine,
                              GraphWeights weights = GraphWeights::kSmooth) {
  EmbeddedOptions options;
  options.node_distance = distance;
  options.nodes = nodes;
  options.weights = weights;
  return options;
}

SolveResult solve(const MeshData& mesh, const Task& task, const EmbeddedOptions& options, double accuracy = 1e-8) {
  EmbeddedDeformation model(mesh.mesh(), options);
  model.set_constraints(task.constraints);
  return model.solve(task.targets, to_accuracy(accuracy, arap::InitialGuess::kHandleRotations, 500));
}

MeshData some_bar() { return bar(4, Faces::kQuads); }
RigidMotion some_bend() { return {rotation_about({0, 0, 1}, .9), {-.1, .4, 0}}; }

/// Both ends, each of that part of the length, are hard; the far one is moved by `map`.
template <class Map>
Task held_ends(const MeshData& mesh, const Map& map, double strength = 1, double part = .15) {
  Task task;
  const Positions rest = mesh.positions();
  const int axis = longest_axis(rest);
  for (const int v : extreme_vertices(rest, axis, part)) task.add(v, rest.row(v));
  for (const int v : extreme_vertices(rest, axis, -part)) task.add(v, map(Vector3(rest.row(v))), strength);
  return task;
}
Task bent(const MeshData& mesh, double strength = 1) {
  return held_ends(
      mesh, [](const Vector3& x) { return some_bend().apply(x); }, strength);
}

class EmbeddedOfEachKind : public testing::TestWithParam<std::tuple<GraphNodes, GraphWeights>> {
 protected:
  [[nodiscard]] static EmbeddedOptions options(double distance) {
    return with_distance(distance, std::get<0>(GetParam()), std::get<1>(GetParam()));
  }
};

TEST_P(EmbeddedOfEachKind, RestStaysAtRestAndARigidMotionIsExact) {
  const RigidMotion motion = Random(2).rigid_motion(2, 1);
  for (const MeshData& mesh : all_small_meshes()) {
    if (mesh.mesh().n_parts() > 1) continue;
    for (const RigidMotion& of_all : {RigidMotion{}, motion}) {
      Task task;
      for (int v = 0; v < mesh.n_vertices(); v += mesh.n_vertices() < 12 ? 1 : 3)
        task.add(v, of_all.apply(mesh.vertices[v]));
      const SolveResult result = solve(mesh, task, options(.2));
      EXPECT_LT(max_distance(result.positions, of_all.apply(mesh.positions())), 1e-6 * mesh.diagonal()) << mesh.name;
      EXPECT_LT(result.energy_after, 1e-10) << mesh.name;
    }
  }
}

TEST_P(EmbeddedOfEachKind, HalfATurnIsExactFromAnyPose) {
  const MeshData mesh = some_bar();
  Task task = bent(mesh);
  EmbeddedDeformation model(mesh.mesh(), options(.1));
  model.set_constraints(task.constraints);
  const Positions posed = model.solve(task.targets, to_accuracy(1e-8)).positions;
  const auto turn = [](const Positions& x) { return Positions(x * rotation_about({1, 2, 3}, std::numbers::pi)); };
  const Positions turned = model.solve(turn(task.targets), to_accuracy(1e-8)).positions;
  EXPECT_LT(max_distance(turned, turn(posed)), 1e-4 * mesh.diagonal());
  model.reset();
  const Positions rest = turn(mesh.positions());
  const SolveResult result = model.solve(values_of(task.constraints, rest), to_accuracy(1e-8));
  EXPECT_LT(max_distance(result.positions, rest), 1e-6 * mesh.diagonal());
}

TEST_P(EmbeddedOfEachKind, HardConstraintsAreMetAndTheEndDoesNotDependOnTheStart) {
  const MeshData mesh = some_bar();
  const Task task = bent(mesh);
  EmbeddedDeformation model(mesh.mesh(), options(.05));
  model.set_constraints(task.constraints);
  const Positions from_rest = model.solve(task.targets, to_accuracy(1e-8)).positions;
  EXPECT_LT(max_distance(values_of(task.constraints, from_rest), task.targets), 1e-4 * mesh.diagonal());
  Positions farther = task.targets;
  farther.col(2).array() += .2;
  model.solve(farther, to_accuracy(1e-4));
  const SolveResult back = model.solve(task.targets, to_accuracy(1e-8));
  EXPECT_LT(max_distance(back.positions, from_rest), 1e-4 * mesh.diagonal());
  EXPECT_EQ(back.stop_reason, arap::StopReason::kConverged);
}

TEST_P(EmbeddedOfEachKind, LargeHeldRegionsAreMetInFewSteps) {
  const MeshData mesh = bar(6, Faces::kQuads);
  const Vector3 joint = mesh.positions().colwise().mean();
  const Matrix3 turn = rotation_about({0, 1, 0}, 1.5);
  const Task task = held_ends(
      mesh, [&](const Vector3& x) { return Vector3(turn * (x - joint) + joint); }, 1, .42);
  EmbeddedDeformation model(mesh.mesh(), options(.05));
  model.set_constraints(task.constraints);
  const SolveResult result = model.solve(task.targets, to_accuracy(1e-6));
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  EXPECT_LT(result.iterations, 80);
  EXPECT_LT(max_distance(values_of(task.constraints, result.positions), task.targets), .005 * mesh.diagonal());
}

TEST_P(EmbeddedOfEachKind, ASolveEndsWhereStepsAreLostInRounding) {
  const MeshData mesh = some_bar();
  for (const double strength : {.5, 1.}) {
    const Task task = bent(mesh, strength);
    EmbeddedDeformation model(mesh.mesh(), options(.1));
    model.set_constraints(task.constraints);
    const SolveResult result = model.solve(task.targets, to_accuracy(1e-15, arap::InitialGuess::kPrevious, 300));
    EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged) << strength;
    EXPECT_EQ(result.step, 0) << strength;
    const SolveResult again = model.solve(task.targets, to_accuracy(1e-10));
    EXPECT_EQ(again.stop_reason, arap::StopReason::kConverged) << strength;
    EXPECT_LT(max_distance(again.positions, result.positions), 1e-9) << strength;
    EXPECT_EQ(model.solve(task.targets, to_accuracy(0, arap::InitialGuess::kPrevious, 40)).stop_reason,
              arap::StopReason::kMaxIterations);
  }
}

TEST_P(EmbeddedOfEachKind, UnitAndPlaceOfTheMeshDoNotMatter) {
  const MeshData mesh = some_bar();
  const Task task = bent(mesh, .5);
  const Positions posed = solve(mesh, task, options(.1)).positions;
  for (const double scale : {.01, 100.}) {
    const Vector3 shift(3 * scale, -2 * scale, scale);
    const MeshData other = transformed(mesh, [&](const Vector3& x) { return Vector3(scale * x + shift); });
    Task scaled = task;
    scaled.targets = (scale * task.targets).rowwise() + shift.transpose();
    const Positions result = solve(other, scaled, options(.1)).positions;
    EXPECT_LT(max_distance((result.rowwise() - shift.transpose()) / scale, posed), 1e-6) << scale;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, EmbeddedOfEachKind,
                         testing::Combine(testing::Values(GraphNodes::kAffine, GraphNodes::kRigid),
                                          testing::Values(GraphWeights::kSmooth, GraphWeights::kNearest)));

TEST(EmbeddedDeformation, GoesBackToRestWithItsTargets) {
  const MeshData mesh = grid(30, Faces::kQuads);
  EmbeddedDeformation model(mesh.mesh(), with_distance(.05));
  const Task task = bent(mesh);
  model.set_constraints(task.constraints);
  model.solve(task.targets, to_accuracy(1e-5));
  const Positions rest = values_of(task.constraints, mesh.positions());
  const SolveResult result = model.solve(rest, to_accuracy(1e-8, arap::InitialGuess::kPrevious, 300));
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  EXPECT_LT(max_distance(result.positions, mesh.positions()), 1e-5 * mesh.diagonal());
}

TEST(EmbeddedDeformation, PositionsBeyondSinglePrecisionAreRefusedAndThePoseStays) {
  const MeshData mesh = transformed(cube(), [](const Vector3& x) { return Vector3(1e60 * x); });
  EmbeddedDeformation model(mesh.mesh(), with_distance(.2));
  const Task task = hold(mesh, {0, 1, 2, 3});
  model.set_constraints(task.constraints);
  std::vector<float> out(24, 7.F);
  expect_error<arap::SolverError>([&] { model.solve(task.targets, {}, {}, {}, out); }, {"too large"});
  EXPECT_LT(max_distance(model.positions(), mesh.positions()), 1e48);
}

TEST(EmbeddedDeformation, TargetsThatNoStepComesNearToAreRefused) {
  const MeshData mesh = some_bar();
  Task task = bent(mesh);
  task.targets(0, 0) = 1e20;
  EmbeddedDeformation model(mesh.mesh(), with_distance(.1));
  model.set_constraints(task.constraints);
  expect_error<arap::SolverError>([&] { model.solve(task.targets); }, {"no step lowers the energy", "far away"});
  EXPECT_LT(max_distance(model.positions(), mesh.positions()), 1e-12);
}

TEST(EmbeddedDeformation, ALargerHandleDoesNotEnlargeTheRest) {
  // Its term of rotations is against that: an affine map of all constraints is not reproduced.
  const MeshData mesh = some_bar();
  const Task task = held_ends(
      mesh, [](const Vector3& x) { return Vector3(1.5 * x); }, 1);
  Task enlarged = task;
  for (size_t k = 0; k < task.constraints.vertices.size(); ++k)
    enlarged.targets.row(static_cast<Eigen::Index>(k)) = 1.5 * mesh.positions().row(task.constraints.vertices[k]);
  const Positions posed = solve(mesh, enlarged, with_distance(.1)).positions;
  EXPECT_GT(max_distance(posed, 1.5 * mesh.positions()), .02 * mesh.diagonal());
}

TEST(EmbeddedDeformation, SoftConstraintsPullAsStronglyAsTheyAre) {
  const MeshData mesh = some_bar();
  double last = std::numeric_limits<double>::infinity();
  for (const double strength : {.001, .1, .9, 1.}) {
    const Task task = bent(mesh, strength);
    const Positions posed = solve(mesh, task, with_distance(.1)).positions;
    const double gap = (values_of(task.constraints, posed) - task.targets).norm();
    EXPECT_LT(gap, .7 * last) << strength;
    last = gap;
  }
}

TEST(EmbeddedDeformation, EnergyOfSoftConstraintsNeverRises) {
  const MeshData mesh = some_bar();
  Task task = bent(mesh, .5);
  std::fill(task.constraints.strengths.begin(), task.constraints.strengths.end(), .5);
  for (const GraphNodes nodes : {GraphNodes::kAffine, GraphNodes::kRigid}) {
    EmbeddedDeformation model(mesh.mesh(), with_distance(.1, nodes));
    model.set_constraints(task.constraints);
    double last = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 12; ++k) {
      const SolveResult result = model.solve(task.targets, iterations(1));
      EXPECT_LE(result.energy_after, result.energy_before * (1 + 1e-12));
      EXPECT_LE(result.energy_after, last * (1 + 1e-12));
      last = result.energy_after;
    }
  }
}

TEST(EmbeddedDeformation, ADenserMeshGivesTheSamePose) {
  const MeshData coarse = triangulate(bar(6, Faces::kQuads));
  const MeshData dense = subdivide(coarse);
  const Task of_coarse = bent(coarse, .5);
  Task of_dense;
  for (size_t k = 0; k < of_coarse.constraints.vertices.size(); ++k)  // its first vertices are the coarse one's
    of_dense.add(of_coarse.constraints.vertices[k], of_coarse.targets.row(static_cast<Eigen::Index>(k)),
                 of_coarse.constraints.strengths[k]);
  const Positions a = solve(coarse, of_coarse, with_distance(.05)).positions;
  const Positions b = solve(dense, of_dense, with_distance(.05)).positions;
  EXPECT_LT(max_distance(a, b.topRows(a.rows())), .02 * coarse.diagonal());
}

TEST(EmbeddedDeformation, PatchesAreHeldAndPartsWithoutConstraintsStay) {
  const MeshData mesh = two_spheres(2);
  EmbeddedDeformation model(mesh.mesh(), with_distance(.1));
  Task task;
  const Positions rest = mesh.positions();
  task.add(0, rest.row(0));
  const std::vector<int> held = {3, 4, 5};
  Vector3 middle = Vector3::Zero();
  for (const int v : held) middle += Vector3(rest.row(v)) / 3;
  const Vector3 target = middle + Vector3(.3, .1, 0);
  task.add_patch(held, {1, 1, 1}, target);
  model.set_constraints(task.constraints);
  const SolveResult result = model.solve(task.targets, to_accuracy(1e-8));
  Vector3 reached = Vector3::Zero();
  for (const int v : held) reached += Vector3(result.positions.row(v)) / 3;
  EXPECT_LT((reached - target).norm(), 1e-6);
  EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (model.part_of_vertex()[v] == 1) {
      EXPECT_LT((result.positions.row(v) - rest.row(v)).norm(), 1e-12);
    }
}

TEST(EmbeddedDeformation, LooseVerticesGoWhereTheyAreHeld) {
  MeshData mesh = some_bar();
  mesh.vertices.emplace_back(9, 9, 9);
  mesh.vertices.emplace_back(-9, 9, 9);
  const int loose = mesh.n_vertices() - 2;
  Task task = bent(some_bar());
  task.add(loose, {1, 2, 3});
  const Positions posed = solve(mesh, task, with_distance(.1)).positions;
  EXPECT_LT((Vector3(posed.row(loose)) - Vector3(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((Vector3(posed.row(loose + 1)) - Vector3(-9, 9, 9)).norm(), 1e-12);
  EXPECT_LT(max_distance(posed.topRows(loose), solve(some_bar(), bent(some_bar()), with_distance(.1)).positions), 1e-4);
}

TEST(EmbeddedDeformation, ACancelledSolveChangesNothing) {
  const MeshData mesh = some_bar();
  const Task task = bent(mesh);
  EmbeddedDeformation model(mesh.mesh(), with_distance(.1));
  model.set_constraints(task.constraints);
  const SolveResult result = model.solve(task.targets, {}, {}, [](double) { return false; });
  EXPECT_EQ(result.stop_reason, arap::StopReason::kCancelled);
  EXPECT_LT(max_distance(result.positions, mesh.positions()), 1e-12);
}

TEST(EmbeddedDeformation, StartsFromGivenPositionsAndGoesBackToRest) {
  const MeshData mesh = some_bar();
  const Task task = bent(mesh);
  EmbeddedDeformation model(mesh.mesh(), with_distance(.1));
  const RigidMotion motion = Random(8).rigid_motion(2, 1);
  model.set_positions(motion.apply(mesh.positions()));
  EXPECT_LT(max_distance(model.positions(), motion.apply(mesh.positions())), 1e-9);
  model.reset();
  EXPECT_LT(max_distance(model.positions(), mesh.positions()), 1e-12);
}

TEST(EmbeddedDeformation, NumberOfThreadsDoesNotMatter) {
  const MeshData mesh = bumpy_sphere(4);
  const Task task = bent(mesh);
  EmbeddedOptions options = with_distance(.08);
  options.threads = 1;
  const Positions one = solve(mesh, task, options).positions;
  options.threads = 3;
  EXPECT_LT(max_distance(one, solve(mesh, task, options).positions), 1e-7);
}

TEST(DeformationGraph, WeightsSumToOneAndWhatIsConnectedStaysSo) {
  for (const MeshData& mesh : all_small_meshes())
    for (const GraphWeights weights : {GraphWeights::kSmooth, GraphWeights::kNearest})
      for (const double distance : {.02, .3}) {
        const MeshData model = in_model_space(mesh);
        const arap::DeformationGraph graph =
            arap::make_graph(model.mesh(), with_distance(distance, GraphNodes::kAffine, weights), 1, {});
        std::vector<int> group(graph.size());
        for (int j = 0; j < graph.size(); ++j) group[j] = j;
        for (int pass = 0; pass < graph.size(); ++pass)
          for (const auto& [j, k] : graph.edges) group[j] = group[k] = std::min(group[j], group[k]);
        std::sort(group.begin(), group.end());
        EXPECT_EQ(std::unique(group.begin(), group.end()) - group.begin(), mesh.mesh().n_parts()) << mesh.name;
        for (int v = 0; v < mesh.n_vertices(); ++v) {
          double sum = 0;
          for (int k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
            sum += graph.weights[k];
            EXPECT_GE(graph.weights[k], 0);
          }
          EXPECT_NEAR(sum, 1, 1e-12) << mesh.name;
        }
      }
}

TEST(EmbeddedDeformation, ErrorsSayWhatIsWrong) {
  const arap::PolygonMesh mesh = cube().mesh();
  const auto bind = [&](double EmbeddedOptions::*option, double value) {
    EmbeddedOptions options;
    options.*option = value;
    EmbeddedDeformation(mesh, options);
  };
  expect_error<InvalidInput>([&] { bind(&EmbeddedOptions::node_distance, 0); }, {"node_distance = 0", ">= 0.005"});
  // Clang 14 captures no structured binding.
  for (const auto& [option, name] : {std::pair{&EmbeddedOptions::rotation_weight, "rotation_weight"},
                                     std::pair{&EmbeddedOptions::regularization_weight, "regularization_weight"},
                                     std::pair{&EmbeddedOptions::constraint_weight, "constraint_weight"}})
    expect_error<InvalidInput>([&, weight = option] { bind(weight, 0); }, {name, ">= 0.1 and <= 1000"});
  const arap::PolygonMesh points(Positions::Random(3, 3), {}, {});
  expect_error<InvalidInput>([&] { EmbeddedDeformation model(points); }, {"no faces", "give it faces"});
}

}  // namespace
}  // namespace arap_test
