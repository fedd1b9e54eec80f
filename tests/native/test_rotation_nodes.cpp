// SPDX-License-Identifier: GPL-3.0-or-later
#include "rotation_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "helpers.h"
#include "model_space.h"
#include "surface_energies.h"

namespace arap_test {
namespace {

using arap::CellEnergy;
using arap::EdgeWeights;
using arap::Energy;
using arap::RotationNodes;
using arap::SolveResult;
using arap::SurfaceArap;

arap::Options with_nodes(double radius) {
  arap::Options options;
  options.energy = Energy::kRotationNodes;
  options.rigidity_radius = radius;
  return options;
}

/// The mesh in model space, where radii are parts of the diagonal.
MeshData normalized(const MeshData& mesh) {
  const Positions rest = arap::ModelSpace(mesh.positions()).points_to_model(mesh.positions());
  MeshData result = mesh;
  for (int v = 0; v < mesh.n_vertices(); ++v) result.vertices[v] = rest.row(v).transpose();
  return result;
}

CellEnergy plain_cells(const MeshData& mesh) {
  arap::Options options;
  options.energy = Energy::kSpokesAndRims;
  return arap::assemble_surface_energy(mesh.mesh(), options, {}, 1, {});
}

/// Nodes of a mesh in model space.
RotationNodes choose(const MeshData& mesh, double radius, const std::vector<std::vector<int>>& mirrors = {},
                     const std::vector<int>& group = {}, int threads = 1) {
  const arap::SurfaceGraph graph(plain_cells(mesh).K, mesh.positions(), threads);
  return arap::choose_rotation_nodes(graph, radius, mirrors, group, threads);
}

Eigen::MatrixXd dense_weights(const RotationNodes& nodes, int n) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(n, nodes.size());
  for (int j = 0; j < n; ++j)
    for (int k = nodes.offsets[j]; k < nodes.offsets[j + 1]; ++k) W(j, nodes.nodes[k]) += nodes.weights[k];
  return W;
}

/// The definition, in the mesh's own unit, with the nodes that the library chooses.
Reference reference(const MeshData& mesh, double radius) {
  Reference result(mesh, Energy::kSpokesAndRims, EdgeWeights::kCotangent);
  const MeshData model = normalized(mesh);
  result.share_rotations(dense_weights(choose(model, radius), mesh.n_vertices()));
  return result;
}

std::vector<MeshData> asymmetric_meshes() {
  std::vector<MeshData> meshes;
  for (MeshData& mesh : all_small_meshes()) {
    Random random(7);
    for (Vector3& p : mesh.vertices) p += random.vector(.002 * mesh.diagonal());
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

TEST(RotationNodes, LibraryEnergyAndGradientAreThoseOfTheDefinition) {
  Random random(31);
  for (const MeshData& mesh : asymmetric_meshes())
    for (const double radius : {.05, .2, .6}) {
      const SurfaceArap solver(mesh.mesh(), with_nodes(radius));
      const Reference plain = reference(mesh, radius);
      const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), .05 * mesh.diagonal());
      const double expected = plain.energy(p);
      EXPECT_NEAR(solver.energy(p), expected, 1e-10 * expected) << mesh.name << ", radius " << radius;
      const Positions gradient = plain.gradient(p);
      EXPECT_LT(max_distance(solver.energy_gradient(p), gradient), 1e-8 * gradient.cwiseAbs().maxCoeff())
          << mesh.name << ", radius " << radius;
    }
}

TEST(RotationNodes, GradientIsThatOfFiniteDifferences) {
  Random random(32);
  for (const MeshData& mesh : {bar(3, Faces::kTriangles), bumpy_sphere(2), grid(6, Faces::kQuads)}) {
    const SurfaceArap solver(mesh.mesh(), with_nodes(.2));
    const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), .02 * mesh.diagonal());
    const Positions gradient = solver.energy_gradient(p);
    for (int k = 0; k < 10; ++k) {
      const Positions direction = random.noise(mesh.n_vertices(), 1);
      const double h = 1e-6 * mesh.diagonal();
      const double slope = (solver.energy(p + h * direction) - solver.energy(p - h * direction)) / (2 * h);
      EXPECT_NEAR(slope, gradient.cwiseProduct(direction).sum(), 1e-6 * gradient.norm() * direction.norm())
          << mesh.name;
    }
  }
}

TEST(RotationNodes, EnergyNeverRises) {
  for (const MeshData& mesh : all_small_meshes())
    for (const double radius : {.05, .2}) {
      SurfaceArap solver(mesh.mesh(), exactly(with_nodes(radius)));
      const Task task = bend_task(mesh, default_bend(mesh));
      solver.set_constraints(task.constraints);
      double energy = solver.solve(task.targets, iterations(1)).energy_after;
      for (int k = 0; k < 30; ++k) {
        const SolveResult result = solver.solve(task.targets, iterations(1));
        const double rounding = 1e-12 * (energy + mesh.diagonal() * mesh.diagonal());
        EXPECT_LE(result.energy_after, energy + rounding) << mesh.name << ", radius " << radius;
        energy = result.energy_after;
      }
    }
}

TEST(RotationNodes, WithTheSupportBelowTheShortestEdgeTheyAreSpokesAndRims) {
  Random random(33);
  for (const MeshData& mesh : all_small_meshes()) {
    arap::Options classic;
    classic.energy = Energy::kSpokesAndRims;
    const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), .05 * mesh.diagonal());
    const double expected = SurfaceArap(mesh.mesh(), classic).energy(p);
    EXPECT_NEAR(SurfaceArap(mesh.mesh(), with_nodes(1e-4)).energy(p), expected, 1e-12 * expected) << mesh.name;
  }
}

TEST(RotationNodes, EveryVertexWithACellLooksAtNodesWithWeightsOfSumOne) {
  for (const MeshData& mesh : all_small_meshes()) {
    const RotationNodes nodes = choose(normalized(mesh), .1);
    const Eigen::VectorXd sums = dense_weights(nodes, mesh.n_vertices()).rowwise().sum();
    EXPECT_LT((sums.array() - 1).abs().maxCoeff(), 1e-14) << mesh.name;
  }
}

TEST(RotationNodes, EachCellIsAtHomeAtItsNodeAndItsRestVectorsSumToZero) {
  for (const MeshData& mesh : all_small_meshes()) {
    const MeshData model = normalized(mesh);
    const RotationNodes nodes = choose(model, .1);
    const CellEnergy energy = arap::share_rotations(plain_cells(model), nodes, 1);
    ASSERT_EQ(energy.n_cells(), nodes.size());
    for (int c = 0; c < energy.n_cells(); ++c) {
      EXPECT_EQ(energy.home(c), nodes.vertices[c]) << mesh.name;
      Vector3 sum = Vector3::Zero();
      for (int e = energy.cell_offsets[c]; e < energy.cell_offsets[c + 1]; ++e) sum += energy.q.row(e).transpose();
      EXPECT_LT(sum.norm(), 1e-11 * energy.q.cwiseAbs().maxCoeff()) << mesh.name;
    }
  }
}

}  // namespace
}  // namespace arap_test
