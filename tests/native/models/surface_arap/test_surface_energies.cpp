// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/surface_energies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "dense/small_matrices.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::CellEnergy;
using arap::EdgeWeights;
using arap::Energy;
using arap::RotationNodes;
using arap::SolveResult;
using arap::SurfaceArap;

CellEnergy assemble(const MeshData& mesh, const arap::Options& options, const std::vector<double>& stiffness = {}) {
  return surface_energy(mesh.mesh(), options, stiffness);
}

std::vector<double> random_stiffness(int n, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> stiffness(static_cast<size_t>(n));
  for (double& s : stiffness) s = std::pow(100, random.uniform(0, 1));
  return stiffness;
}

/// E of the one form, written out.
double one_form(const CellEnergy& energy, const Positions& p, const std::vector<Matrix3>& rotations) {
  double sum = .5 * p.cwiseProduct(Positions(energy.K * p)).sum() + energy.rest_energy;
  for (int c = 0; c < energy.n_cells(); ++c)
    for (const auto& [v, q] : entries_of(energy.cells, c)) sum -= p.row(v).dot((rotations[c] * q).transpose());
  return sum;
}

/// Expects energy_gradient() to be the derivative of energy() at `p`.
void expect_gradient(SurfaceArap& solver, const Positions& p, double size, const std::string& what) {
  const Positions gradient = solver.energy_gradient(p);
  const Positions expected = differences([&](const Positions& at) { return solver.energy(at); }, p, 1e-5 * size);
  EXPECT_LT(max_distance(gradient, expected), 1e-6 * gradient.cwiseAbs().maxCoeff()) << what;
}

class SurfaceEnergies : public OfEachModel {};

/// What is assembled: one cell a vertex, also where rotation nodes are made of it.
class CellsOfVertices : public SurfaceEnergies {};

TEST_P(CellsOfVertices, MatrixIsThatOfTheReference) {
  for (const MeshData& mesh : all_small_meshes()) {
    const Eigen::MatrixXd K = assemble(mesh, options()).K;
    EXPECT_LT((K - reference(mesh).matrix()).cwiseAbs().maxCoeff(), 1e-10 * K.cwiseAbs().maxCoeff()) << mesh.name;
    EXPECT_LT((K - K.transpose()).cwiseAbs().maxCoeff(), 1e-13 * K.cwiseAbs().maxCoeff()) << mesh.name;
    EXPECT_LT(K.rowwise().sum().cwiseAbs().maxCoeff(), 1e-11 * K.cwiseAbs().maxCoeff()) << mesh.name;
  }
}

TEST_P(CellsOfVertices, OneFormIsTheDoubleSum) {
  Random random(21);
  for (const MeshData& mesh : all_small_meshes()) {
    const CellEnergy energy = assemble(mesh, options());
    const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), .2);
    std::vector<Matrix3> rotations;
    for (int c = 0; c < mesh.n_vertices(); ++c) rotations.push_back(random.rigid_motion(1, 0).rotation);
    const double expected = reference(mesh).energy(p, rotations);
    EXPECT_NEAR(one_form(energy, p, rotations), expected, 1e-10 * expected) << mesh.name;
  }
}

TEST_P(CellsOfVertices, EachCellIsAtHomeAtItsVertex) {
  for (const MeshData& mesh : all_small_meshes()) {
    const CellEnergy energy = assemble(mesh, options());
    for (int c = 0; c < energy.n_cells(); ++c) {
      int n_at_vertex = 0;
      energy.cells.for_each_cell(c, [&](int, const Vector3&) { ++n_at_vertex; });
      EXPECT_EQ(energy.cells.home(c), n_at_vertex == 0 ? -1 : c) << mesh.name;
    }
  }
}

TEST_P(SurfaceEnergies, EnergyAndGradientAreThoseOfTheReference) {
  Random random(24);
  for (const MeshData& mesh : all_small_meshes()) {
    SurfaceArap solver(mesh.mesh(), options());
    const Reference plain = reference(mesh);
    for (const double noise : {.01, .1, 1.0}) {
      const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), noise * mesh.diagonal());
      const double expected = plain.energy(p);
      const Positions gradient = solver.energy_gradient(p);
      // A small difference of large sums over rest vectors of 40 binary digits.
      EXPECT_NEAR(solver.energy(p), expected, 1e-9 * expected) << mesh.name << ", noise " << noise;
      EXPECT_LT(max_distance(gradient, plain.gradient(p)), 1e-9 * gradient.cwiseAbs().maxCoeff()) << mesh.name;
    }
  }
}

TEST_P(SurfaceEnergies, GradientIsThatOfFiniteDifferences) {
  for (const MeshData& mesh : {bumpy_sphere(1), l_prism(4), sheared_cylinder(8, 4)}) {
    SurfaceArap solver(mesh.mesh(), options());
    expect_gradient(solver, mesh.positions() + Random(24).noise(mesh.n_vertices(), .05 * mesh.diagonal()),
                    mesh.diagonal(), mesh.name);
  }
}

TEST_P(SurfaceEnergies, IsZeroForRigidMotions) {
  Random random(25);
  for (const MeshData& mesh : all_small_meshes()) {
    SurfaceArap solver(mesh.mesh(), options());
    const double size = mesh.diagonal() * mesh.diagonal();
    const Positions moved = random.rigid_motion(2, mesh.diagonal()).apply(mesh.positions());
    EXPECT_NEAR(solver.energy(moved), 0, 1e-12 * size) << mesh.name;
    EXPECT_LT(solver.energy_gradient(moved).cwiseAbs().maxCoeff(), 1e-10 * mesh.diagonal()) << mesh.name;
  }
}

TEST_P(SurfaceEnergies, StiffnessScalesWholeCells) {
  Random random(26);
  for (const MeshData& mesh : {bumpy_sphere(1), quad_sphere(3), star_prism(5, 3), sheared_cylinder(8, 4)}) {
    const std::vector<double> stiffness = random_stiffness(mesh.n_vertices(), 5);
    SurfaceArap solver(mesh.mesh(), options(), {stiffness, {}});
    const Reference plain = reference(mesh, stiffness);
    const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), .1);
    EXPECT_NEAR(solver.energy(p), plain.energy(p), 1e-10 * plain.energy(p)) << mesh.name;
    EXPECT_LT(max_distance(solver.energy_gradient(p), plain.gradient(p)), 1e-9 * plain.gradient(p).norm()) << mesh.name;
  }
}

TEST_P(CellsOfVertices, MatrixIsPositiveDefiniteWithOneVertexErasedWhateverTheStiffness) {
  for (const MeshData& mesh : {bumpy_sphere(1), sheared_cylinder(10, 5), star_prism(7, 3)}) {
    const Eigen::MatrixXd K = assemble(mesh, options(), random_stiffness(mesh.n_vertices(), 6)).K;
    const auto rest = Eigen::seq(1, K.rows() - 1);
    EXPECT_GT(arap::symmetric_eigen(Eigen::MatrixXd(K(rest, rest))).values.minCoeff(), 0) << mesh.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Classics, CellsOfVertices, testing::ValuesIn(classic_models()), model_name);
INSTANTIATE_TEST_SUITE_P(AllModels, SurfaceEnergies, testing::ValuesIn(all_models()), model_name);

TEST(SpokesAndRims, CornersOnStraightSidesAddNoEnergyOfTheirOwn) {
  // Fans whose triangles are collinear drop out; the other fans hold the corner.
  const MeshData mesh = sheet_with_collinear_corners();
  const Reference plain(mesh, Energy::kSpokesAndRims, EdgeWeights::kCotangent);
  SurfaceArap solver(mesh.mesh());
  const Positions p = mesh.positions() + Random(27).noise(mesh.n_vertices(), .1);
  EXPECT_NEAR(solver.energy(p), plain.energy(p), .05 * plain.energy(p));
  EXPECT_NEAR(solver.energy(default_bend(mesh).apply(mesh.positions())), 0, 1e-12);
}

TEST(SpokesAndRims, EnergyOfEachTriangleIsNotNegative) {
  // One obtuse triangle, its corners anywhere.
  const MeshData mesh{"obtuse", {{0, 0, 0}, {1, 0, 0}, {-3, .3, 0}}, {{0, 1, 2}}};
  SurfaceArap solver(mesh.mesh());
  Random random(28);
  for (int trial = 0; trial < 100; ++trial) EXPECT_GE(solver.energy(random.noise(3, 5)), -1e-12);
}

TEST(Spokes, SingleNegativeCotangentsCountAsZero) {
  // Two obtuse triangles at an edge: with the sum of cotangents clamped, or not at all, its weight would differ.
  const MeshData mesh{"kite", {{0, 0, 0}, {1, 0, 0}, {.5, .1, 0}, {.5, -2, 0}}, {{0, 1, 2}, {1, 0, 3}}};
  const Eigen::MatrixXd K = assemble(mesh, {.energy = Energy::kSpokes}).K;
  const double sharp = 2 * std::atan(.25);  // the angle at vertex 3
  EXPECT_NEAR(K(0, 1), -4 * .5 / std::tan(sharp), 1e-12);
}

// Where vertices are not each for themselves.

TEST(SurfaceArapEnergy, OfJoinedVerticesTheFirstCounts) {
  const MeshData mesh = cylinder_with_open_seam(8, 3, Faces::kTriangles);
  constexpr int kFirstCopy = 8 * 4;
  for (const Model& model : all_models()) {
    arap::Options options = model.options();
    options.join_seams = true;
    SurfaceArap solver(mesh.mesh(), options);
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

TEST(SurfaceArapEnergy, WithRegionsIsTheOneThatASolveMinimizes) {
  const Regions regions;
  const MeshData& mesh = regions.mesh;
  const Task task = bend_task(mesh, default_bend(mesh));
  for (const Model& model : all_models()) {
    SurfaceArap solver(mesh.mesh(), exactly(model.options()), with_regions(regions.labels));
    solver.set_constraints(task.constraints);
    const SolveResult result = solver.solve(task.targets, to_accuracy(1e-10));
    EXPECT_NEAR(solver.energy(result.positions), result.energy_after, 1e-9 * result.energy_after) << model.name();
    SurfaceArap free(mesh.mesh(), model.options());
    EXPECT_LT(free.energy(result.positions), .99 * result.energy_after) << model.name() << ": shared rotations cost";
  }
}

TEST(SurfaceArapEnergy, GradientWithRegionsIsThatOfFiniteDifferences) {
  const Regions regions;
  const MeshData& mesh = regions.mesh;
  const Positions p = mesh.positions() + Random(4).noise(mesh.n_vertices(), .03 * mesh.diagonal());
  for (const Model& model : all_models()) {
    SurfaceArap solver(mesh.mesh(), model.options(), with_regions(regions.labels));
    expect_gradient(solver, p, mesh.diagonal(), model.name());
    EXPECT_LT(solver.energy_gradient(RigidMotion{rotation_about({1, 2, 3}, 1), {1, 0, 2}}.apply(mesh.positions()))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-10 * mesh.diagonal())
        << model.name();
  }
}

// Assembly.

/// Rest vector of each incidence, by home of the cell and vertex, as `number` calls them.
std::map<std::pair<int, int>, Vector3> by_home_and_vertex(const CellEnergy& energy, const std::vector<int>& number) {
  std::map<std::pair<int, int>, Vector3> result;
  for (int c = 0; c < energy.n_cells(); ++c)
    for (const auto& [v, q] : entries_of(energy.cells, c)) result[{number[energy.cells.home(c)], number[v]}] = q;
  return result;
}

/// Expects the cells of each vertex to be those that have it, with the same rest vectors.
void expect_index_by_vertex(const CellEnergy& energy) {
  std::map<std::pair<int, int>, Vector3> by_cell;
  for (int c = 0; c < energy.n_cells(); ++c)
    for (const auto& [v, q] : entries_of(energy.cells, c)) by_cell[{v, c}] = q;
  ASSERT_EQ(by_cell.size(), energy.cells.n_incidences());
  size_t n_seen = 0;
  for (int v = 0; v < energy.n_vertices(); ++v)
    energy.cells.for_each_cell(v, [&](int c, const Vector3& q) {
      ++n_seen;
      EXPECT_LT((by_cell.at({v, c}) - q).norm(), 1e-10);
    });
  EXPECT_EQ(n_seen, by_cell.size());
}

TEST(Assemble, InAnotherOrderEverythingIsTheSameUnderItsNewNumber) {
  for (const MeshData& mesh : {bumpy_sphere(2), bumpy_sphere(4)}) {
    const int n = mesh.n_vertices();
    const RotationNodes nodes = choose_nodes(in_model_space(mesh), .1);
    for (const bool has_nodes : {false, true}) {
      const auto choose = [&] { return has_nodes ? nodes : arap::node_at_each_vertex(n); };
      std::vector<int> order(static_cast<size_t>(n));
      std::iota(order.begin(), order.end(), 0);
      CellEnergy as_it_is;
      arap::assemble_surface_energy(as_it_is, mesh.mesh(), {}, {}, 2, {}, choose);
      const auto expected = by_home_and_vertex(as_it_is, order);
      std::reverse(order.begin() + 3, order.end());
      CellEnergy energy;
      arap::assemble_surface_energy(energy, mesh.mesh(), {}, {}, 2, {}, choose, [&] { return &order; });
      EXPECT_EQ(by_home_and_vertex(energy, order), expected);
      EXPECT_EQ(energy.rest_energy, as_it_is.rest_energy);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; j += 7) ASSERT_EQ(energy.K.coeff(i, j), as_it_is.K.coeff(order[i], order[j]));
      expect_index_by_vertex(energy);
      expect_index_by_vertex(as_it_is);
    }
  }
}

TEST(Assemble, ThreadsDoNotChangeTheResult) {
  const MeshData mesh = bumpy_sphere(4);
  const CellEnergy one = surface_energy(mesh.mesh());
  const CellEnergy two = surface_energy(mesh.mesh(), {}, {}, 2);
  EXPECT_EQ((one.K - two.K).norm(), 0);
  std::vector<int> numbers(static_cast<size_t>(mesh.n_vertices()));
  std::iota(numbers.begin(), numbers.end(), 0);
  EXPECT_EQ(by_home_and_vertex(one, numbers), by_home_and_vertex(two, numbers));
  EXPECT_EQ(one.rest_energy, two.rest_energy);
}

TEST(Energy, TooFarAwayForANumberIsRefused) {
  MeshData small = bumpy_sphere(1);
  const Positions far = 1e99 * small.positions();
  for (Vector3& vertex : small.vertices) vertex *= 1e-80;
  SurfaceArap solver(small.mesh());
  const auto expect_refused = [](const auto& ask) {
    expect_error<arap::SolverError>(ask, {"too large for a number", "sizes of the mesh away"});
  };
  expect_refused([&] { static_cast<void>(solver.energy(far)); });
  expect_refused([&] { static_cast<void>(solver.energy_gradient(far)); });
}

}  // namespace
}  // namespace arap_test
