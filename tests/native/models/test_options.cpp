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

TEST(Options, OutOfRangeIsRefused) {
  const auto expect_refused = [](const arap::Options& options, std::initializer_list<std::string_view> words) {
    expect_error<InvalidInput>([&] { options.validate(); }, words);
  };
  for (const double radius : {0.0, -1.0, 9e-7, 1.01, kNan, kInfinity})
    expect_refused({.rigidity_radius = radius}, {"rigidity_radius", ">= 1e-6 and <= 1"});
  expect_refused({.threads = -1}, {"threads", "-1", "must be 0"});
  // No machine has them; starting them would end the process.
  expect_refused({.threads = 100000}, {"threads", "100000", "1024"});
}

TEST(Options, BindRefusesWhatValidateRefuses) {
  const arap::Options options{.threads = -3};
  expect_error<InvalidInput>([&] { const arap::SurfaceArap solver(tetrahedron().mesh(), options); }, {"threads", "-3"});
}

TEST(SolveOptions, OutOfRangeIsRefused) {
  const arap::SolveOptions least{.max_iterations = 1, .accuracy = 0, .time_limit_s = 1e-300};
  EXPECT_NO_THROW(least.validate());
  const auto expect_refused = [](const arap::SolveOptions& options, std::initializer_list<std::string_view> words) {
    expect_error<InvalidInput>([&] { options.validate(); }, words);
  };
  expect_refused({.max_iterations = 0}, {"max_iterations", "0", ">= 1"});
  for (const double bad : {-1e-3, kNan, kInfinity}) expect_refused({.accuracy = bad}, {"accuracy", ">= 0"});
  for (const double bad : {0.0, -1.0, kNan}) expect_refused({.time_limit_s = bad}, {"time_limit_s", "> 0"});
}

TEST(SolveOptions, SolveRefusesWhatValidateRefuses) {
  const MeshData mesh = tetrahedron();
  const Task task = hold(mesh, {0});
  expect_error<InvalidInput>([&] { solve_once(mesh, task, {.max_iterations = -2}); }, {"max_iterations", "-2"});
}

}  // namespace
}  // namespace arap_test
