// SPDX-License-Identifier: GPL-3.0-or-later
// SurfaceArap::energy() and its gradient where vertices are not each for themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::SolveResult;
using arap::SurfaceArap;

/// Of SurfaceArap::energy, by central differences.
Positions differences(const SurfaceArap& solver, const Positions& p, double h) {
  Positions result(p.rows(), 3);
  for (Eigen::Index v = 0; v < p.rows(); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      Positions forth = p;
      Positions back = p;
      forth(v, axis) += h;
      back(v, axis) -= h;
      result(v, axis) = (solver.energy(forth) - solver.energy(back)) / (2 * h);
    }
  return result;
}

void expect_gradient(const SurfaceArap& solver, const Positions& p, double size, const std::string& what) {
  const Positions gradient = solver.energy_gradient(p);
  EXPECT_LT(max_distance(gradient, differences(solver, p, 1e-5 * size)), 1e-6 * gradient.cwiseAbs().maxCoeff()) << what;
}

TEST(Energy, OfJoinedVerticesTheFirstCounts) {
  const MeshData mesh = cylinder_with_open_seam(8, 3, Faces::kTriangles);
  constexpr int kFirstCopy = 8 * 4;
  for (const Model& model : all_models()) {
    arap::Options options = model.options();
    options.join_seams = true;
    const SurfaceArap solver(mesh.mesh(), options);
    Positions p = mesh.positions() + Random(3).noise(mesh.n_vertices(), .05 * mesh.diagonal());
    expect_gradient(solver, p, mesh.diagonal(), model.name());
    const double energy = solver.energy(p);
    p.bottomRows(mesh.n_vertices() - kFirstCopy).array() += .1;
    EXPECT_EQ(solver.energy(p), energy) << model.name();
  }
}

/// Where one motion is of all kinds: a round region, one of two vertices, one of a single vertex.
struct Regions {
  MeshData mesh = bumpy_sphere(2);
  std::vector<int> labels = std::vector<int>(static_cast<size_t>(mesh.n_vertices()), -1);

  Regions() {
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (std::abs(mesh.vertices[v].x()) < .4 && mesh.vertices[v].z() > 0) labels[v] = 0;
    int face = 0;
    while (mesh.vertices[mesh.faces[face][0]].z() > -.6 || std::abs(mesh.vertices[mesh.faces[face][0]].x()) > .3)
      ++face;
    labels[mesh.faces[face][0]] = labels[mesh.faces[face][1]] = 1;
    labels[mesh.faces[face][2]] = 2;
  }
};

TEST(Energy, WithRegionsIsTheOneThatASolveMinimizes) {
  const Regions regions;
  const MeshData& mesh = regions.mesh;
  const Task task = bend_task(mesh, default_bend(mesh));
  for (const Model& model : all_models()) {
    SurfaceArap solver(mesh.mesh(), exactly(model.options()), with_regions(regions.labels));
    solver.set_constraints(task.constraints);
    const SolveResult result = solver.solve(task.targets, to_accuracy(1e-10));
    EXPECT_NEAR(solver.energy(result.positions), result.energy_after, 1e-9 * result.energy_after) << model.name();
    const SurfaceArap free(mesh.mesh(), model.options());
    EXPECT_LT(free.energy(result.positions), .99 * result.energy_after) << model.name() << ": shared rotations cost";
  }
}

TEST(Energy, GradientWithRegionsIsThatOfFiniteDifferences) {
  const Regions regions;
  const MeshData& mesh = regions.mesh;
  const Positions p = mesh.positions() + Random(4).noise(mesh.n_vertices(), .03 * mesh.diagonal());
  for (const Model& model : all_models()) {
    const SurfaceArap solver(mesh.mesh(), model.options(), with_regions(regions.labels));
    expect_gradient(solver, p, mesh.diagonal(), model.name());
    EXPECT_LT(solver.energy_gradient(RigidMotion{rotation_about({1, 2, 3}, 1), {1, 0, 2}}.apply(mesh.positions()))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-10 * mesh.diagonal())
        << model.name();
  }
}

TEST(Energy, TooFarAwayForANumberIsRefused) {
  const MeshData mesh = bumpy_sphere(1);
  MeshData small = mesh;
  for (Vector3& vertex : small.vertices) vertex *= 1e-80;
  const SurfaceArap solver(small.mesh());
  const Positions far = 1e99 * mesh.positions();
  for (const auto& ask : {std::function<void()>([&] { static_cast<void>(solver.energy(far)); }),
                          std::function<void()>([&] { static_cast<void>(solver.energy_gradient(far)); })})
    expect_error<arap::SolverError>(ask, {"too large for a number", "sizes of the mesh away"});
}

}  // namespace
}  // namespace arap_test
