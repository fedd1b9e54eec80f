// SPDX-License-Identifier: GPL-3.0-or-later
// What a solve leaves behind is no start for one that starts elsewhere.
#include <gtest/gtest.h>

#include <array>

#include "support/any_model.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InitialGuess;

constexpr std::array kGuesses = {InitialGuess::kPrevious, InitialGuess::kRest, InitialGuess::kNaiveLaplacian,
                                 InitialGuess::kHandleRotations};

RigidMotion small_turn() { return {rotation_about({.3, 1, .2}, .3), {.05, .1, -.05}}; }

class OfEachKind : public testing::TestWithParam<KindOfModel> {};

TEST_P(OfEachKind, EqualCallsGiveEqualResultsWhateverCameBefore) {
  const Task task = pull_on(GetParam(), small_turn());
  const Task far = pull_on(GetParam(), {rotation_about({.3, 1, .2}, 1.2), {.2, .6, -.3}});
  for (const InitialGuess guess : kGuesses) {
    const std::unique_ptr<AnyModel> model = GetParam().bind(1);
    model->set_constraints(task.constraints);
    const arap::SolveOptions options = to_accuracy(1e-10, guess);
    const Positions first = model->solve(task.targets, options).positions;
    // A solve from the previous pose only comes nearer to the end.
    const double tolerance = guess == InitialGuess::kPrevious ? 1e-5 : 1e-13;
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(max_distance(model->solve(task.targets, options).positions, first), tolerance) << int(guess);
      if (k == 0) model->solve(far.targets, iterations(2));
    }
  }
}

TEST_P(OfEachKind, TheWayBackToRestLeavesNothing) {
  Task pulled = pull_on(GetParam(), small_turn());
  const auto n = static_cast<Eigen::Index>(pulled.constraints.vertices.size());
  const arap::ConstraintSet ends{pulled.constraints.vertices, {}, {}};
  const Positions at_rest = values_of(ends, GetParam().rest);
  for (const InitialGuess guess : kGuesses) {
    const std::unique_ptr<AnyModel> model = GetParam().bind(1);
    model->set_constraints(ends);
    model->solve(pulled.targets.topRows(n), to_accuracy(1e-9));
    model->solve(at_rest, to_accuracy(1e-9));
    EXPECT_LE(max_distance(model->solve(at_rest, to_accuracy(1e-9, guess)).positions, GetParam().rest), 1e-7)
        << int(guess);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, OfEachKind, testing::ValuesIn(kinds_of_models()),
                         [](const testing::TestParamInfo<KindOfModel>& kind) { return kind.param.name; });

}  // namespace
}  // namespace arap_test
