// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "arap/cage_arap.h"
#include "arap/embedded_deformation.h"
#include "arap/error.h"
#include "arap/lattice_arap.h"
#include "arap/options.h"
#include "arap/poisson_editing.h"
#include "arap/tet_arap.h"
#include "arap/wrap_deformation.h"
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
    expect_refused({.rigidity_radius = radius}, {"rigidity_radius", ">= 1e-06 and <= 1"});
  expect_refused({.threads = -1}, {"threads", "-1", "must be 0"});
  // No machine has them; starting them would end the process.
  expect_refused({.threads = 100000}, {"threads", "100000", "1024"});
}

template <class OptionsOfAClass>
void expect_bounded_threads(const char* name) {
  for (const int bad : {-1, 1025, 5000, std::numeric_limits<int>::max()}) {
    SCOPED_TRACE(name);
    OptionsOfAClass options;
    options.threads = bad;
    expect_error<InvalidInput>([&] { options.validate(); },
                               {"threads = " + std::to_string(bad) + ", must be 0 (as many as pay) to 1024"});
    options.threads = 1024;
    EXPECT_NO_THROW(options.validate());
  }
}

TEST(Options, ThreadsAreBoundedInEveryClass) {
  expect_bounded_threads<arap::Options>("Options");
  expect_bounded_threads<arap::LatticeOptions>("LatticeOptions");
  expect_bounded_threads<arap::TetOptions>("TetOptions");
  expect_bounded_threads<arap::EmbeddedOptions>("EmbeddedOptions");
  expect_bounded_threads<arap::PoissonOptions>("PoissonOptions");
  expect_bounded_threads<arap::CageArapOptions>("CageArapOptions");
  expect_bounded_threads<arap::CageOptions>("CageOptions");
  expect_bounded_threads<arap::WrapOptions>("WrapOptions");
  const arap::PolygonMesh mesh = cube().mesh();
  expect_error<InvalidInput>([&] { const arap::WrapSurface surface(mesh, 5000); }, {"threads = 5000"});
  expect_error<InvalidInput>([&] { static_cast<void>(mesh.same_places(5000)); }, {"threads = 5000"});
}

/// Of each number the bounds are taken, and what is beyond them is refused.
template <class OptionsOfAClass>
void expect_bounds(double OptionsOfAClass::*field, double least, double most) {
  OptionsOfAClass options;
  for (const double good : {least, most}) {
    options.*field = good;
    EXPECT_NO_THROW(options.validate()) << good;
  }
  for (const double bad : {least * (1 - 1e-6) - 1e-300, most * (1 + 1e-6), -kInfinity, kInfinity, kNan}) {
    options.*field = bad;
    expect_error<InvalidInput>([&] { options.validate(); }, {"must be >= ", " and <= "});
  }
}

TEST(Options, EveryNumberIsBounded) {
  expect_bounds(&arap::Options::rigidity_radius, 1e-6, 1);
  expect_bounds(&arap::LatticeOptions::cube_size, 1e-3, 1);
  expect_bounds(&arap::LatticeOptions::keep_volume, 0, 1);
  expect_bounds(&arap::EmbeddedOptions::node_distance, .005, 1);
  expect_bounds(&arap::EmbeddedOptions::rotation_weight, .1, 1000);
  expect_bounds(&arap::EmbeddedOptions::regularization_weight, .1, 1000);
  expect_bounds(&arap::EmbeddedOptions::constraint_weight, .1, 1000);
  expect_bounds(&arap::CageArapOptions::rigidity_radius, 1e-6, 1);
  expect_bounds(&arap::CageArapOptions::grid_spacing, .005, .1);
  expect_bounds(&arap::CageOptions::grid_spacing, .005, .1);
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
