// SPDX-License-Identifier: GPL-3.0-or-later
// What the size of a mesh is, and which of its vertices are one.
#include "model_space.h"

#include <gtest/gtest.h>

#include <vector>

#include "helpers.h"

namespace arap_test {
namespace {

using arap::SolveResult;

TEST(ModelSpace, LooseVerticesDoNotMakeTheMeshLarger) {
  const MeshData near = bumpy_sphere(2);
  MeshData far = near;
  far.add_vertex({1e4, 0, 0});
  EXPECT_DOUBLE_EQ(far.mesh().diagonal(), near.diagonal());
  const Task task = bend_task(near, default_bend(near));
  const SolveResult without = solve_once(near, task, iterations(5));
  const SolveResult with = solve_once(far, task, iterations(5));
  EXPECT_NEAR(with.step, without.step, 1e-6 * without.step) << "of the size of the surface";
  EXPECT_LT(max_distance(with.positions.topRows(near.n_vertices()), without.positions), 1e-8 * near.diagonal());
}

TEST(ModelSpace, WithoutFacesAllVerticesAreItsSize) {
  const MeshData points{"points", {{1, 1, 1}, {4, 5, 1}}, {}};
  EXPECT_DOUBLE_EQ(points.mesh().diagonal(), 5);
  EXPECT_DOUBLE_EQ(arap::ModelSpace(points.mesh()).size(), 5);
}

}  // namespace
}  // namespace arap_test
