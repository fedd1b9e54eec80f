// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/drag_predictor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::DragPredictor;
using arap::SurfaceArap;

Positions step(const Vector3& of_all) { return of_all.transpose().replicate(3, 1); }

Positions some(double value) { return Positions::Constant(4, 3, value); }

DragPredictor learned(const Vector3& of_all, const Positions& change = some(1)) {
  DragPredictor prediction;
  prediction.observe(change, 0, arap::Workers(1));
  prediction.learn(step(of_all), arap::Workers(1));
  return prediction;
}

/// What it adds for a share of 1.
Positions change_of(const DragPredictor& prediction) {
  Positions change = some(0);
  prediction.add_to(change, 1, arap::Workers(1));
  return change;
}

TEST(DragPredictor, GoesOnAsFarAsTheTargetsDo) {
  const DragPredictor prediction = learned({1, 2, 0});
  EXPECT_DOUBLE_EQ(prediction.share(step({1, 2, 0})), 1);
  EXPECT_DOUBLE_EQ(prediction.share(step({.5, 1, 0})), .5);
  EXPECT_DOUBLE_EQ(prediction.share(step({3, 1, 7})), 1) << "what is across counts nothing";
  EXPECT_DOUBLE_EQ(prediction.share(step({-2, 1, 0})), 0);
  EXPECT_DOUBLE_EQ(prediction.share(step({-1, -2, 0})), -1) << "the way back is the way there";
  EXPECT_DOUBLE_EQ(prediction.share(step({0, 0, 0})), 0);
  EXPECT_DOUBLE_EQ(prediction.share(step({100, 200, 0})), 1.5) << "a leap is not foretold";
  EXPECT_DOUBLE_EQ(prediction.share(step({-100, -200, 0})), -1.5);
}

TEST(DragPredictor, KnowsNothingAtFirstNorOfOtherTargets) {
  EXPECT_EQ(DragPredictor().share(step({1, 0, 0})), 0);
  EXPECT_EQ(DragPredictor().share(Positions(0, 3)), 0);
  EXPECT_EQ(learned({1, 0, 0}).share(Positions::Ones(2, 3)), 0);
  EXPECT_EQ(learned({1, 0, 0}).share(Positions(0, 3)), 0);
  EXPECT_EQ(learned({0, 0, 0}).share(step({1, 0, 0})), 0);
}

TEST(DragPredictor, ForgetsTheLastFrameAndWhatAFrameThatIsNotLearnedShowed) {
  DragPredictor prediction = learned({1, 0, 0}, some(.5));
  prediction.observe(some(8), 1, arap::Workers(1));
  EXPECT_EQ(change_of(prediction), some(.5));
  prediction.forget();
  EXPECT_EQ(prediction.share(step({1, 0, 0})), 0);
}

TEST(DragPredictor, KnowsNothingOfForcesBeyondAFloat) {
  EXPECT_EQ(learned({1, 0, 0}, some(1e60)).share(step({1, 0, 0})), 0);
}

TEST(DragPredictor, FindsTheChangeOfTheForcesThroughWhatItAdded) {
  // K = 1: a step goes to p = b + share * (last change), and the fit there leaves b_new - p.
  const std::vector<double> forces = {1, 1.5, 1.75, 2.5, 2};
  DragPredictor prediction;
  double change = 0;
  for (size_t k = 0; k + 1 < forces.size(); ++k) {
    const double share = k == 0 ? 0 : .75;
    const double reached = forces[k] + share * change;
    prediction.observe(some(forces[k + 1] - reached), share, arap::Workers(1));
    prediction.learn(step({1, 0, 0}), arap::Workers(1));
    change = forces[k + 1] - forces[k];
    EXPECT_EQ(change_of(prediction), some(change)) << "frame " << k;
  }
}

/// Frames of a few iterations, the far end of a bar turned and moved evenly, beside the poses that they would have
/// converged to.
struct Drag {
  MeshData mesh = bar(8, Faces::kQuads);
  arap::VertexProperties properties;
  double strength = 1;
  bool has_patch = false;  ///< the far end is held by the average of its vertices
  int n_frames = 20;

  [[nodiscard]] static arap::Options options() { return {.rigidity_radius = .06}; }
  [[nodiscard]] Task at(int frame) const {
    const double share = static_cast<double>(frame) / n_frames;
    const Vector3 shift = Vector3(-.1, 0, .2) * share * mesh.diagonal();
    if (has_patch) return patch_at(shift);
    Task task = bend_task(mesh, {rotation_about({.2, 1, .3}, 1.2 * share), shift});
    for (size_t k = 0; k < task.constraints.strengths.size(); k += 2) task.constraints.strengths[k] = strength;
    return task;
  }
  [[nodiscard]] Task patch_at(const Vector3& shift) const {
    const Positions rest = mesh.positions();
    const int axis = longest_axis(rest);
    Task task = hold(mesh, extreme_vertices(rest, axis, .2, 3));
    const std::vector<int> patch = extreme_vertices(rest, axis, -.05, 3);
    const std::vector<double> weights(patch.size(), 1);
    task.add_patch(patch, weights, average(rest, patch, weights) + shift);
    return task;
  }
  [[nodiscard]] std::vector<Positions> frames(const arap::SolveOptions& solve_options,
                                              const std::function<void(SurfaceArap&)>& between = {}) const {
    SurfaceArap solver(mesh.mesh(), options(), properties);
    solver.set_constraints(at(0).constraints);
    std::vector<Positions> result;
    for (int frame = 0; frame <= n_frames; ++frame) {
      result.push_back(solver.solve(at(frame).targets, solve_options).positions);
      if (between) between(solver);
    }
    return result;
  }
  [[nodiscard]] std::vector<Positions> converged() const { return frames(to_accuracy(1e-7)); }
  /// Of each frame, how far it is from there, in diagonals.
  [[nodiscard]] std::vector<double> behind(const std::vector<Positions>& converged,
                                           const std::vector<Positions>& frames) const {
    std::vector<double> result;
    for (size_t k = 0; k < frames.size(); ++k)
      result.push_back(max_distance(frames[k], converged[k]) / mesh.diagonal());
    return result;
  }
};

/// Takes the prediction away: positions that come from elsewhere have no last frame.
void set_again(SurfaceArap& solver) { solver.set_positions(solver.positions()); }

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

void expect_nearer(const char* what, const Drag& drag, double part = .5) {
  const std::vector<Positions> converged = drag.converged();
  for (const int n : {1, 2, 3}) {
    const std::vector<double> with = drag.behind(converged, drag.frames(iterations(n)));
    const std::vector<double> without = drag.behind(converged, drag.frames(iterations(n), set_again));
    EXPECT_LT(mean(with), part * mean(without)) << what << ", " << n << " iterations a frame";
    EXPECT_LT(*std::max_element(with.begin(), with.end()), *std::max_element(without.begin(), without.end())) << what;
  }
}

TEST(Prediction, ADragIsNearerToWhereItConverges) {
  expect_nearer("hard", {});
  Drag soft;
  soft.strength = .5;
  expect_nearer("soft", soft);
  Drag region;
  std::vector<int> regions(region.mesh.n_vertices(), -1);
  for (int v = 0; v < region.mesh.n_vertices(); ++v)
    if (std::abs(region.mesh.vertices[v][0]) < .05 * region.mesh.diagonal()) regions[v] = 0;
  region.properties = with_regions(regions);
  expect_nearer("region", region);
  Drag patch;
  patch.has_patch = true;
  expect_nearer("patch", patch, .75);
}

TEST(Prediction, CatchingUpNowAndThenIsNotTakenForMotion) {
  // What many iterations make good at once would, gone on with, be the next lag, and a larger one.
  Drag drag;
  drag.n_frames = 60;
  const std::vector<Positions> converged = drag.converged();
  const auto most = [&](int every, int many) {
    SurfaceArap solver(drag.mesh.mesh(), drag.options());
    solver.set_constraints(drag.at(0).constraints);
    std::vector<Positions> frames;
    for (int frame = 0; frame <= drag.n_frames; ++frame)
      frames.push_back(
          solver.solve(drag.at(frame).targets, iterations(frame % every == every - 1 ? many : 1)).positions);
    const std::vector<double> behind = drag.behind(converged, frames);
    return *std::max_element(behind.begin(), behind.end());
  };
  const double evenly = most(1, 1);
  for (const int every : {2, 5, 10})
    for (const int many : {5, 12, 60}) EXPECT_LT(most(every, many), 1.5 * evenly) << many << " iterations, " << every;
}

TEST(Prediction, DoesNotChangeWhereADragConverges) {
  const Drag drag;
  const std::vector<Positions> with = drag.frames(to_accuracy(1e-8));
  const std::vector<Positions> without = drag.frames(to_accuracy(1e-8), set_again);
  for (size_t k = 0; k < with.size(); ++k) EXPECT_LT(max_distance(with[k], without[k]), 1e-5 * drag.mesh.diagonal());
}

TEST(Prediction, ADragGoesOnAfterAFrameFarAway) {
  const Drag drag;
  SurfaceArap solver(drag.mesh.mesh(), drag.options());
  solver.set_constraints(drag.at(0).constraints);
  for (int frame = 0; frame <= drag.n_frames; ++frame) {
    const Positions targets = (frame == 5 ? 1e42 : 1) * drag.at(frame).targets;
    ASSERT_NO_THROW(static_cast<void>(solver.solve(targets, iterations(2)))) << "frame " << frame;
  }
}

TEST(Prediction, ACancelledFrameIsNoneOfTheDrag) {
  const Drag drag;
  const Positions elsewhere = bend_task(drag.mesh, default_bend(drag.mesh)).targets;
  const std::vector<Positions> cancelled = drag.frames(iterations(2), [&](SurfaceArap& solver) {
    int n_calls = 0;
    static_cast<void>(solver.solve(elsewhere, iterations(9), {}, [&](double) { return ++n_calls < 3; }));
  });
  const std::vector<Positions> undisturbed = drag.frames(iterations(2));
  for (size_t k = 0; k < cancelled.size(); ++k)
    EXPECT_LT(max_distance(cancelled[k], undisturbed[k]), 1e-6 * drag.mesh.diagonal()) << "frame " << k;
}

}  // namespace
}  // namespace arap_test
