// SPDX-License-Identifier: GPL-3.0-or-later
// What the size of a mesh is, and which of its vertices are one.
#include "models/model_space.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::SolveResult;
using arap::SurfaceArap;

TEST(ModelSpace, LooseVerticesDoNotMakeTheMeshLarger) {
  const MeshData near = bumpy_sphere(2);
  const Task task = bend_task(near, default_bend(near));
  const SolveResult without = solve_once(near, task, iterations(5));
  for (const double distance : {1e2, 1e4, 1e9}) {
    MeshData far = near;
    far.add_vertex({distance, 0, 0});
    EXPECT_DOUBLE_EQ(far.mesh().diagonal(), near.diagonal());
    const SolveResult with = solve_once(far, task, iterations(5));
    EXPECT_NEAR(with.step, without.step, 1e-6 * without.step) << "of the size of the surface";
    EXPECT_LT(max_distance(with.positions.topRows(near.n_vertices()), without.positions), 1e-8 * near.diagonal())
        << distance;
  }
}

TEST(ModelSpace, LooseVerticesFarAwayCostNoPrecision) {
  // So many vertices that single precision does: the same numbers, bit by bit, wherever the loose one is.
  const MeshData near = bumpy_sphere(4);
  const Task task = bend_task(near, default_bend(near));
  arap::SolveOptions options = iterations(3);
  options.accuracy = 1e-4;
  const auto solved = [&](double distance) {
    MeshData mesh = near;
    const int loose = mesh.add_vertex({distance, 0, 0});
    const Positions positions = solve_once(mesh, task, options).positions;
    EXPECT_LT((positions.row(loose) - Eigen::RowVector3d(distance, 0, 0)).norm(), 1e-12 * distance);
    return Positions(positions.topRows(near.n_vertices()));
  };
  const Positions expected = solved(.1);
  for (const double distance : {1e2, 1e4, 1e9}) EXPECT_TRUE(solved(distance) == expected) << distance;
}

TEST(ModelSpace, AHeldLooseVertexGoesToItsTarget) {
  MeshData mesh = bumpy_sphere(2);
  const int loose = mesh.add_vertex({40, 0, 0});
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints({{3, loose}, {1, 1}, {}});
  Positions targets(2, 3);
  targets << mesh.positions().row(3), 41, 2, 3;
  std::vector<float> out(3 * static_cast<size_t>(mesh.n_vertices()));
  solver.solve(targets, iterations(3), {}, {}, out);
  EXPECT_LT((solver.positions().row(loose) - targets.row(1)).norm(), 1e-12);
  EXPECT_EQ(Eigen::RowVector3f::Map(&out[3 * static_cast<size_t>(loose)]), targets.row(1).cast<float>());
}

TEST(ModelSpace, WithoutFacesAllVerticesAreItsSize) {
  const MeshData points{"points", {{1, 1, 1}, {4, 5, 1}}, {}};
  EXPECT_DOUBLE_EQ(points.mesh().diagonal(), 5);
  EXPECT_DOUBLE_EQ(arap::ModelSpace(points.mesh()).size(), 5);
}

TEST(ModelSpace, LooseVertexJoinedToTheSurfaceIsNotLoose) {
  MeshData mesh = bumpy_sphere(1);
  const int copy = mesh.add_vertex(mesh.vertices[3]);
  EXPECT_EQ(SurfaceArap(mesh.mesh()).loose_vertices(), std::vector<int>{copy});
  const arap::Options options{.join_seams = true};
  SurfaceArap solver(mesh.mesh(), options);
  EXPECT_TRUE(solver.loose_vertices().empty());
  EXPECT_EQ(solver.part_of_vertex()[copy], 0);
  const Task task = bend_task(mesh, default_bend(mesh));
  solver.set_constraints(task.constraints);
  const SolveResult result = solver.solve(task.targets, iterations(3));
  EXPECT_TRUE(result.loose_vertices.empty());
  EXPECT_EQ(result.positions.row(copy), result.positions.row(3));
}

}  // namespace
}  // namespace arap_test
