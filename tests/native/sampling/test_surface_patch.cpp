// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/surface_patch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InvalidInput;
using arap::Patch;
using arap::SolveResult;
using arap::SurfaceArap;

TEST(SurfacePatch, IsRoundAndFadesOut) {
  const MeshData mesh = transformed(grid(20, Faces::kQuads), [](const Vector3& p) { return Vector3(3 * p); });
  SurfaceArap solver(mesh.mesh());
  const double radius = .1;
  const int centre = 10 * 21 + 10;
  const Patch patch = solver.patch_around({centre}, radius);
  EXPECT_NEAR(std::accumulate(patch.weights.begin(), patch.weights.end(), 0.0), 1, 1e-12);
  EXPECT_LT((average(mesh.positions(), patch.vertices, patch.weights) - patch.rest_position).norm(), 1e-12);
  EXPECT_LT((patch.rest_position - mesh.vertices[centre]).norm(), 1e-9);
  EXPECT_EQ(patch.vertices.front(), centre);
  // In the plane, away from its border, all areas are alike.
  for (size_t k = 0; k < patch.vertices.size(); ++k) {
    const Vector3 off = mesh.vertices[patch.vertices[k]] - mesh.vertices[centre];
    // Along the edges and diagonals of squares the path is straight.
    const bool is_straight = std::abs(off[0] * off[1] * (std::abs(off[0]) - std::abs(off[1]))) < 1e-12;
    const double part = off.norm() / (radius * mesh.diagonal());
    EXPECT_LT(part, 1);
    if (is_straight) {
      EXPECT_NEAR(patch.weights[k] / patch.weights.front(), std::pow(1 - part * part, 3), 1e-5);
    }
  }
}

TEST(SurfacePatch, DefaultRadiusIsOneAndAHalfRigidityRadii) {
  const MeshData mesh = bumpy_sphere(3);
  const Patch by_default = SurfaceArap(mesh.mesh(), {.rigidity_radius = .08}).patch_around({5});
  const Patch given = SurfaceArap(mesh.mesh(), {.rigidity_radius = .3}).patch_around({5}, .12);
  EXPECT_EQ(by_default.vertices, given.vertices);
  EXPECT_EQ(by_default.weights, given.weights);
}

TEST(SurfacePatch, SmallerThanAnEdgeIsTheVertex) {
  const MeshData mesh = bumpy_sphere(2);
  const Patch patch = SurfaceArap(mesh.mesh()).patch_around({7}, 1e-4);
  EXPECT_EQ(patch.vertices, std::vector<int>{7});
  EXPECT_EQ(patch.weights, std::vector<double>{1});
}

TEST(SurfacePatch, OfALineOfVerticesLiesAroundAllOfThem) {
  const MeshData mesh = grid(20, Faces::kQuads);
  std::vector<int> line;
  for (int x = 5; x < 16; ++x) line.push_back(10 * 21 + x);
  const Patch patch = SurfaceArap(mesh.mesh()).patch_around(line, .05);
  EXPECT_LT((patch.rest_position - mesh.vertices[10 * 21 + 10]).norm(), 1e-9);
  EXPECT_GT(patch.vertices.size(), line.size());
}

TEST(SurfacePatch, StaysOnItsPart) {
  const MeshData mesh = two_spheres(2);
  SurfaceArap solver(mesh.mesh());
  const Patch patch = solver.patch_around({0}, 1);
  for (const int v : patch.vertices) EXPECT_EQ(solver.part_of_vertex()[v], solver.part_of_vertex()[0]);
}

TEST(SurfacePatch, OfFacesWithoutAreaCountsEveryVertexByItsDistance) {
  MeshData line;
  for (int k = 0; k < 3; ++k) line.add_vertex(Vector3(k, 0, 0));
  line.faces.push_back({0, 1, 2});
  const Patch patch = SurfaceArap(line.mesh()).patch_around({1}, 1);
  EXPECT_NEAR(std::accumulate(patch.weights.begin(), patch.weights.end(), 0.0), 1, 1e-12);
  EXPECT_LT((patch.rest_position - Vector3(1, 0, 0)).norm(), 1e-9);
}

/// How far a point handle pulls the surface at a distance, on refinements of one shape.
TEST(SurfacePatch, APointPullIsTheSameAtEveryDensity) {
  MeshData mesh = grid(12, Faces::kTriangles);
  const int n_common = mesh.n_vertices();
  const arap::Options classic{.energy = arap::Energy::kSpokesAndRims};
  std::vector<Positions> pulled;
  std::vector<Positions> spiked;
  for (int level = 0; level < 3; ++level) {
    if (level > 0) mesh = subdivide(mesh);
    const int centre = mesh.vertex_at(Vector3(0, 0, 0));
    std::vector<int> border;
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (mesh.vertices[v].head<2>().cwiseAbs().maxCoeff() > .5 - 1e-9) border.push_back(v);
    Task task = hold(mesh, border);
    Task spike = task;
    const Patch patch = SurfaceArap(mesh.mesh(), {.rigidity_radius = .07}).patch_around({centre});
    task.add_patch(patch.vertices, patch.weights, patch.rest_position + Vector3(0, 0, .15));
    pulled.emplace_back(
        solve_once(mesh, task, to_accuracy(1e-7), {.rigidity_radius = .07}).positions.topRows(n_common));
    spike.add(centre, mesh.vertices[centre] + Vector3(0, 0, .15));
    spiked.emplace_back(solve_once(mesh, spike, to_accuracy(1e-7), classic).positions.topRows(n_common));
  }
  EXPECT_LT(max_distance(pulled[2], pulled[1]), .005 * mesh.diagonal());
  EXPECT_GT(max_distance(spiked[2], spiked[1]), .005 * mesh.diagonal());
}

TEST(SurfacePatch, PatchesAloneConvergeToTheAccuracy) {
  const MeshData mesh = open_cylinder(12, 30, Faces::kQuads);
  SurfaceArap model(mesh.mesh());
  Task task;
  for (const auto& [vertex, move] :
       {std::pair<int, Vector3>{3, {0, 0, 0}}, {12 * 15 + 2, {0, .3, 0}}, {12 * 28 + 5, {0, -.6, -.4}}}) {
    const Patch patch = model.patch_around({vertex});
    task.add_patch(patch.vertices, patch.weights, patch.rest_position + move);
  }
  const SolveResult end = solve_once(mesh, task, to_accuracy(1e-12, arap::InitialGuess::kPrevious, 2000));
  for (const double accuracy : {1e-8, 1e-10}) {
    const SolveResult result = solve_once(mesh, task, to_accuracy(accuracy, arap::InitialGuess::kPrevious, 1000));
    EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged) << accuracy;
    EXPECT_LT(max_distance(result.positions, end.positions), accuracy * mesh.diagonal()) << accuracy;
  }
}

TEST(SurfacePatch, BadInputIsNamed) {
  MeshData mesh = cube();
  mesh.add_vertex(Vector3(2, 2, 2));
  SurfaceArap solver(mesh.mesh());
  expect_error<InvalidInput>([&] { static_cast<void>(solver.patch_around({})); }, {"at least one vertex"});
  expect_error<InvalidInput>([&] { static_cast<void>(solver.patch_around({9})); }, {"vertex 9", "0 to 8"});
  expect_error<InvalidInput>([&] { static_cast<void>(solver.patch_around({8})); }, {"vertex 8", "no face"});
  for (const double radius : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")})
    expect_error<InvalidInput>([&] { static_cast<void>(solver.patch_around({0}, radius)); }, {"radius", ">= 0"});
}

}  // namespace
}  // namespace arap_test
