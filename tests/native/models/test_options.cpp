// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <limits>

#include "arap/error.h"
#include "arap/options.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InvalidInput;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Options, DefaultsAreRotationNodesWithCotangents) {
  const arap::Options options;
  EXPECT_NO_THROW(options.validate());
  EXPECT_EQ(options.energy, arap::Energy::kRotationNodes);
  EXPECT_EQ(options.rigidity_radius, .02);
  EXPECT_EQ(options.weights, arap::EdgeWeights::kCotangent);
  EXPECT_EQ(options.threads, 0);
  EXPECT_FALSE(options.join_seams);
}

TEST(Options, RigidityRadiusIsAPartOfTheDiagonal) {
  for (const double radius : {0.0, -1.0, 9e-7, 1.01, kNan, kInfinity}) {
    arap::Options options;
    options.rigidity_radius = radius;
    expect_error<InvalidInput>([&] { options.validate(); }, {"rigidity_radius", ">= 1e-6 and <= 1"});
  }
}

TEST(Options, NegativeThreadsAreRefused) {
  arap::Options options;
  options.threads = -1;
  expect_error<InvalidInput>([&] { options.validate(); }, {"threads", "-1", "must be 0"});
}

TEST(Options, TooManyThreadsAreRefused) {
  // No machine has them; starting them would end the process.
  arap::Options options;
  options.threads = 100000;
  expect_error<InvalidInput>([&] { options.validate(); }, {"threads", "100000", "1024"});
}

TEST(Options, BindRefusesWhatValidateRefuses) {
  arap::Options options;
  options.threads = -3;
  const arap::PolygonMesh mesh = tetrahedron().mesh();
  expect_error<InvalidInput>([&] { const arap::SurfaceArap solver(mesh, options); }, {"threads", "-3"});
}

TEST(SolveOptions, DefaultsGoOnFromThePreviousPositionsWithoutTimeLimit) {
  const arap::SolveOptions options;
  EXPECT_NO_THROW(options.validate());
  EXPECT_EQ(options.initial_guess, arap::InitialGuess::kPrevious);
  EXPECT_EQ(options.time_limit_s, kInfinity);
}

TEST(SolveOptions, LeastValuesAreAccepted) {
  arap::SolveOptions options;
  options.max_iterations = 1;
  options.accuracy = 0;
  options.time_limit_s = 1e-300;
  EXPECT_NO_THROW(options.validate());
}

TEST(SolveOptions, NoIterationsAreRefused) {
  arap::SolveOptions options;
  options.max_iterations = 0;
  expect_error<InvalidInput>([&] { options.validate(); }, {"max_iterations", "0", ">= 1"});
}

TEST(SolveOptions, BadAccuracyIsRefused) {
  arap::SolveOptions options;
  for (const double bad : {-1e-3, kNan, kInfinity}) {
    options.accuracy = bad;
    expect_error<InvalidInput>([&] { options.validate(); }, {"accuracy", ">= 0"});
  }
}

TEST(SolveOptions, BadTimeLimitIsRefused) {
  arap::SolveOptions options;
  for (const double bad : {0.0, -1.0, kNan}) {
    options.time_limit_s = bad;
    expect_error<InvalidInput>([&] { options.validate(); }, {"time_limit_s", "> 0"});
  }
}

TEST(SolveOptions, SolveRefusesWhatValidateRefuses) {
  const MeshData mesh = tetrahedron();
  const Task task = hold(mesh, {0});
  arap::SolveOptions options;
  options.max_iterations = -2;
  expect_error<InvalidInput>([&] { solve_once(mesh, task, options); }, {"max_iterations", "-2"});
}

}  // namespace
}  // namespace arap_test
