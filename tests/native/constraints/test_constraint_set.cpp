// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/constraints.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "arap/error.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::ConstraintSet;
using arap::InvalidInput;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kVertices = 5;

TEST(ConstraintSet, HardSoftAndPatchesTogetherAndPatchesAloneAreValid) {
  const ConstraintSet set{{4, 0, 2}, {1, .5, 1e-6}, {{0, 2, 3}, {1, 2, 3}, {1, 0, 4}}};
  EXPECT_NO_THROW(set.validate(kVertices));
  EXPECT_EQ(set.patches.size(), 2);
  EXPECT_EQ(set.n_targets(), 5);
  EXPECT_NO_THROW((ConstraintSet{{}, {}, set.patches}.validate(kVertices)));
}

TEST(ConstraintSet, WithoutStrengthsAllVerticesAreHard) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  Task bare = task;
  bare.constraints.strengths.clear();
  EXPECT_NO_THROW(bare.constraints.validate(mesh.n_vertices()));
  EXPECT_EQ(solve_once(mesh, bare, iterations(3)).positions, solve_once(mesh, task, iterations(3)).positions);
}

TEST(ConstraintSet, EqualityComparesEverything) {
  const ConstraintSet set{{4, 0}, {1, .5}, {{0, 2}, {1, 2}, {1, 1}}};
  ConstraintSet other = set;
  EXPECT_EQ(set, other);
  other.strengths[1] = .6;
  EXPECT_NE(set, other);
  other = set;
  other.vertices[0] = 3;
  EXPECT_NE(set, other);
  other = set;
  other.patches.weights[0] = 2;
  EXPECT_NE(set, other);
}

TEST(ConstraintSet, WhatIsWrongIsRefusedByPlace) {
  const auto expect_refused = [](const ConstraintSet& set, std::initializer_list<std::string_view> words) {
    expect_error<InvalidInput>([&] { set.validate(kVertices); }, words);
  };
  // Vertices and their strengths.
  expect_refused({}, {"constrain", "at least one"});
  expect_refused({{}, {}, {{0}, {}, {}}}, {"constrain", "at least one"});
  for (const int bad : {-1, kVertices, 1 << 30})
    expect_refused({{0, bad}, {1, 1}, {}}, {"vertices", "1", std::to_string(bad), "0 to 4"});
  expect_refused({{3, 0, 3}, {1, 1, .5}, {}}, {"vertex 3", "twice", "0", "2"});
  for (const double bad : {0.0, -.5, 1.0000001, kNan, kInfinity})
    expect_refused({{0, 2}, {1, bad}, {}}, {"strengths[1]", "vertex 2"});
  expect_refused({{0, 1, 2}, {1, 1}, {}}, {"strengths", "2", "3"});
  // Patches.
  expect_refused({{}, {}, {{0, 2}, {1, 2}, {1}}}, {"patch", "weights", "1", "2"});
  for (const std::vector<int>& offsets :
       {std::vector<int>{1, 3}, {0, 1}, {0, 4}, {}, {0, 2, 1, 3}, {0, -1, 3}, {0, 1 << 30, 3}})
    expect_refused({{0}, {1}, {offsets, {1, 2, 3}, {1, 1, 1}}}, {"patch", "offsets"});
  for (const int bad : {-1, kVertices})
    expect_refused({{}, {}, {{0, 2}, {1, bad}, {1, 1}}}, {"patch", std::to_string(bad), "0 to 4"});
  for (const double bad : {-1.0, kNan, kInfinity})
    expect_refused({{}, {}, {{0, 1, 3}, {1, 2, 3}, {1, 1, bad}}}, {"patch 1", "vertex 3", ">= 0"});
  expect_refused({{}, {}, {{0, 2}, {1, 2}, {0, 0}}}, {"patch 0", "weight"});
  expect_refused({{}, {}, {{0, 1, 1}, {1}, {1}}}, {"patch 1", "weight"});
}

TEST(ConstraintSet, SetConstraintsRefusesWhatValidateRefusesAndKeepsTheFormerSet) {
  const MeshData mesh = bumpy_sphere(1);
  arap::SurfaceArap solver(mesh.mesh());
  const Task task = bend_task(mesh, default_bend(mesh));
  solver.set_constraints(task.constraints);
  const int n_factorizations = solver.n_factorizations();
  expect_error<InvalidInput>(
      [&] {
        solver.set_constraints({{0, mesh.n_vertices()}, {1, 1}, {}});
      },
      {std::to_string(mesh.n_vertices())});
  expect_error<InvalidInput>([&] { solver.set_constraints({}); }, {"constrain"});
  EXPECT_EQ(solver.n_factorizations(), n_factorizations);
  const Positions expected = solve_once(mesh, task, iterations(5)).positions;
  EXPECT_EQ(solver.solve(task.targets, iterations(5)).positions, expected);
}

}  // namespace
}  // namespace arap_test
