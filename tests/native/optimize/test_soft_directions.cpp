// SPDX-License-Identifier: GPL-3.0-or-later
// What little holds moves by small forces and short steps: a solve that says it has converged must have seen that.
#include "optimize/soft_directions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "arap/surface_arap.h"
#include "support/any_model.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

/// Of the accuracy: a ribbon with uniform weights is off by 1.55, all others here by less than 1.5.
constexpr double kMostOff = 1.6;

struct Named {
  std::string name;
  MeshData mesh;
};

std::vector<Named> meshes() {
  return {
      {"bar", box({16, 4, 4}, {4, 1, 1}, Faces::kQuads)},
      {"ribbon", box({80, 3, 3}, {12, .5, .5}, Faces::kQuads)},
      {"sheet", grid(20, Faces::kQuads, [](double x, double y) { return .05 * std::sin(7 * x) * std::cos(5 * y); })},
      {"ball", quad_sphere(8)}};
}

/// The lowest vertices along x stay; the highest one goes there.
Task pull_at_a_point(const Positions& rest, int n_held, const Vector3& shift) {
  Task task;
  for (const int v : extreme_vertices(rest, 0, 0, n_held)) task.add(v, rest.row(v).transpose());
  const int far = extreme_vertices(rest, 0, 0, static_cast<int>(rest.rows())).back();
  task.add(far, rest.row(far).transpose() + shift);
  return task;
}

double diagonal_of(const Positions& rest) { return (rest.colwise().maxCoeff() - rest.colwise().minCoeff()).norm(); }

/// Of one solve that converges, and of one that goes on far beyond: the distance as a part of the accuracy.
template <class AModel>
double off_by(AModel& model, const Positions& targets, double accuracy, double diagonal) {
  const arap::SolveResult there = model.solve(targets, to_accuracy(accuracy));
  EXPECT_EQ(there.stop_reason, arap::StopReason::kConverged);
  const arap::SolveResult beyond = model.solve(targets, to_accuracy(1e-3 * accuracy));
  EXPECT_EQ(beyond.stop_reason, arap::StopReason::kConverged);
  return max_distance(there.positions, beyond.positions) / (accuracy * diagonal);
}

class SoftDirections : public OfEachModel {};

TEST_P(SoftDirections, AConvergedPoseIsAsNearAsItSaysWherePointsHoldIt) {
  for (const Named& each : meshes()) {
    const Positions rest = each.mesh.positions();
    const double diagonal = each.mesh.diagonal();
    arap::SurfaceArap model(each.mesh.mesh(), options());
    for (const int n_held : {3, static_cast<int>(rest.rows()) / 10})
      for (const double shift : {.02, .1, .3}) {
        const Task task = pull_at_a_point(rest, n_held, shift * diagonal * Vector3(-.3, .6, .5));
        model.set_constraints(task.constraints);
        for (const double accuracy : {1e-3, 1e-5}) {
          model.reset();
          EXPECT_LE(off_by(model, task.targets, accuracy, diagonal), kMostOff)
              << each.name << ", " << n_held << " held, " << shift << ", " << accuracy;
        }
      }
  }
}

TEST_P(SoftDirections, FramesOfADragAreAsNearAsTheySay) {
  constexpr double kAccuracy = 1e-4;
  for (const Named& each : meshes()) {
    const Positions rest = each.mesh.positions();
    const double diagonal = each.mesh.diagonal();
    const Task task = pull_at_a_point(rest, 3, diagonal * Vector3(-.1, .2, .15));
    const Positions at_rest = values_of(task.constraints, rest);
    for (const int n_frames : {4, 12}) {
      arap::SurfaceArap model(each.mesh.mesh(), options());
      model.set_constraints(task.constraints);
      for (int frame = 1; frame < n_frames; ++frame)
        model.solve(at_rest + double(frame) / n_frames * (task.targets - at_rest), to_accuracy(kAccuracy));
      EXPECT_LE(off_by(model, task.targets, kAccuracy, diagonal), kMostOff) << each.name << ", " << n_frames;
    }
  }
}

/// Beside one or two points all of it can turn: nothing holds that, and only rounding says what it is off.
TEST_P(SoftDirections, WhatCanTurnAsAWholeConvergesToo) {
  const MeshData mesh = grid(20, Faces::kQuads, [](double x, double y) { return .02 * std::sin(9 * x + 5 * y * y); });
  for (const std::vector<int>& held : {std::vector<int>{0}, {0, mesh.n_vertices() - 1}}) {
    Task task;
    for (const int v : held)
      task.add(v, mesh.vertices[v] + (v == held.back() ? Vector3(.05, .1, .2) : Vector3(Vector3::Zero())));
    arap::SurfaceArap model(mesh.mesh(), options());
    model.set_constraints(task.constraints);
    for (const double accuracy : {1e-6, 1e-8, 1e-9}) {
      model.reset();
      EXPECT_EQ(model.solve(task.targets, to_accuracy(accuracy)).stop_reason, arap::StopReason::kConverged)
          << held.size() << " held, " << accuracy;
    }
  }
}

TEST_P(SoftDirections, AreFoundThoughEachSolveHasTimeForOneIterationOnly) {
  const MeshData mesh = grid(20, Faces::kQuads);
  const Task task = pull_at_a_point(mesh.positions(), 1, {.1, .2, .3});
  arap::SurfaceArap model(mesh.mesh(), options());
  model.set_constraints(task.constraints);
  const int n_at_once = model.solve(task.targets, to_accuracy(1e-6)).iterations;
  model.reset();
  arap::SolveOptions hurried = to_accuracy(1e-6);
  hurried.time_limit_s = 1e-9;
  int n_solves = 1;
  while (model.solve(task.targets, hurried).stop_reason != arap::StopReason::kConverged && n_solves < 4 * n_at_once)
    ++n_solves;
  EXPECT_LT(n_solves, 4 * n_at_once);
}

INSTANTIATE_TEST_SUITE_P(Models, SoftDirections, testing::ValuesIn(all_models()), model_name);

TEST(SoftDirectionsOf, EachKindOfModel) {
  for (const KindOfModel& kind : kinds_of_models()) {
    const double diagonal = diagonal_of(kind.rest);
    const std::unique_ptr<AnyModel> model = kind.bind(1);
    for (const double shift : {.02, .1, .3}) {
      const Task task = pull_at_a_point(kind.rest, 3, shift * diagonal * Vector3(-.3, .6, .5));
      model->set_constraints(task.constraints);
      for (const double accuracy : {1e-3, 1e-5}) {
        model->set_positions(kind.rest);
        EXPECT_LE(off_by(*model, task.targets, accuracy, diagonal), kMostOff)
            << kind.name << ", " << shift << ", " << accuracy;
      }
    }
  }
}

}  // namespace
}  // namespace arap_test
