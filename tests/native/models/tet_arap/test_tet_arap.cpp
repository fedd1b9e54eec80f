// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/tet_arap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "references/eigen_solvers.h"
#include "support/helpers.h"
#include "support/tet_arap.h"

namespace arap_test {
namespace {

using arap::SolveResult;
using arap::TetArap;
using arap::TetOptions;

/// A bar whose vertices are moved a little, so that no tetrahedron is like another; of about size 1.
TetMesh uneven_bar(int nx = 6, int n = 3) {
  const TetMesh even = tet_blocks(nx, n, n);
  return {even.positions() + Random(3).noise(even.n_vertices(), .1 / nx), even.tets()};
}

std::vector<int> low_end(const TetMesh& mesh) { return extreme_vertices(mesh.positions(), 0, .2); }
std::vector<int> far_end(const TetMesh& mesh) { return extreme_vertices(mesh.positions(), 0, -.2); }

/// The low end stays, the other one moves.
Task bend(const TetMesh& mesh, const RigidMotion& motion, double strength = 1) {
  Task task;
  for (const int v : low_end(mesh)) task.add(v, mesh.positions().row(v));
  for (const int v : far_end(mesh)) task.add(v, motion.apply(Vector3(mesh.positions().row(v))), strength);
  return task;
}

RigidMotion some_motion() { return {rotation_about({.2, 1, .3}, .7), {-.05, .1, .2}}; }

TetOptions with_threads(int threads) {
  TetOptions options;
  options.threads = threads;
  return options;
}

SolveResult solve(const TetMesh& mesh, const Task& task, double accuracy = 1e-9, const TetOptions& options = {},
                  const arap::VertexProperties& properties = {}) {
  TetArap solver(mesh, options, properties);
  solver.set_constraints(task.constraints);
  return solver.solve(task.targets, to_accuracy(accuracy, arap::InitialGuess::kRest));
}

Matrix3 gradient_in(const TetMesh& mesh, int t, const Positions& p) {
  Matrix3 F = Matrix3::Zero();
  const Eigen::Matrix<double, 4, 3> g = gradients(mesh, t);
  for (int j = 0; j < 4; ++j) F += p.row(mesh.tets()[t][j]).transpose() * g.row(j);
  return F;
}

/// As it is written down.
double energy_of(const TetMesh& mesh, const Positions& p, const std::vector<double>& stiffness = {}) {
  double sum = 0;
  for (int t = 0; t < mesh.n_tets(); ++t) {
    const Matrix3 F = gradient_in(mesh, t, p);
    double s = 1;
    if (!stiffness.empty())
      for (const int v : mesh.tets()[t]) s *= std::pow(stiffness[v], .25);
    sum += tet_volume(mesh, t) * s * (F - best_rotation(F)).squaredNorm();
  }
  return sum;
}

std::vector<double> some_stiffness(const TetMesh& mesh) {
  std::vector<double> stiffness;
  Random random(4);
  for (int v = 0; v < mesh.n_vertices(); ++v) stiffness.push_back(std::exp(random.uniform(-2, 2)));
  return stiffness;
}

TEST(TetArap, RestsAndMovesRigidly) {
  const TetMesh mesh = uneven_bar();
  EXPECT_LT(max_distance(solve(mesh, bend(mesh, {})).positions, mesh.positions()), 1e-9);
  const RigidMotion motion = Random(8).rigid_motion(2, .5);
  Task moved;
  for (const int v : low_end(mesh)) moved.add(v, motion.apply(Vector3(mesh.positions().row(v))));
  TetArap solver(mesh);
  solver.set_constraints(moved.constraints);
  const SolveResult result = solver.solve(moved.targets, to_accuracy(1e-10, arap::InitialGuess::kHandleRotations));
  EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-9);
  EXPECT_NEAR(result.energy_after, 0, 1e-15);
}

TEST(TetArap, EnergyIsTheSumOverTetrahedra) {
  const TetMesh mesh = uneven_bar();
  const Positions p = mesh.positions() + Random(2).noise(mesh.n_vertices(), .05);
  EXPECT_NEAR(TetArap(mesh).energy(p), energy_of(mesh, p), 1e-12 * energy_of(mesh, p));
  const std::vector<double> stiffness = some_stiffness(mesh);
  const double stiff = energy_of(mesh, p, stiffness);
  EXPECT_NEAR(TetArap(mesh, {}, {stiffness, {}}).energy(p), stiff, 1e-12 * stiff);
  EXPECT_NEAR(TetArap(mesh).energy(mesh.positions()), 0, 1e-15);
}

TEST(TetArap, EnergyOfAnAffineMapIsVolumeTimesItsDistanceFromARotation) {
  const TetMesh mesh = uneven_bar();
  Matrix3 A;
  A << 1.2, .3, -.1, .2, .8, .1, 0, -.4, 1.1;
  double whole = 0;
  for (int t = 0; t < mesh.n_tets(); ++t) whole += tet_volume(mesh, t);
  const Positions p = (mesh.positions() * A.transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
  const double expected = whole * (A - best_rotation(A)).squaredNorm();
  EXPECT_NEAR(TetArap(mesh).energy(p), expected, 1e-12 * expected);
}

TEST(TetArap, GradientIsThatOfTheEnergy) {
  const TetMesh mesh = uneven_bar(4, 2);
  const Positions p = mesh.positions() + Random(2).noise(mesh.n_vertices(), .05);
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  for (const int v : far_end(mesh)) regions[v] = 7;
  for (const bool has_region : {false, true}) {
    TetArap solver(mesh, {}, {some_stiffness(mesh), has_region ? regions : std::vector<int>()});
    const Positions expected = differences([&](const Positions& at) { return solver.energy(at); }, p, 1e-5);
    EXPECT_LT(max_distance(solver.energy_gradient(p), expected), 1e-7) << has_region;
  }
}

TEST(TetArap, EnergyGrowsWithTheCubeOfTheSize) {
  const TetMesh mesh = uneven_bar();
  const double size = 7;
  const TetMesh large = transformed(mesh, [&](const Vector3& x) { return Vector3(size * x); });
  const Positions p = mesh.positions() + Random(2).noise(mesh.n_vertices(), .05);
  TetArap solver(mesh);
  TetArap of_large(large);
  const double cube = size * size * size;
  EXPECT_NEAR(of_large.energy(size * p), cube * solver.energy(p), 1e-11 * cube);
  EXPECT_LT(max_distance(of_large.energy_gradient(size * p), size * size * solver.energy_gradient(p)), 1e-11 * cube);
  const Task task = bend(mesh, some_motion());
  EXPECT_NEAR(solve(large, {task.constraints, size * task.targets}).energy_after, cube * solve(mesh, task).energy_after,
              1e-9 * cube);
}

/// A map that is affine at the surface is affine inside: forces of constant stress cancel at every vertex.
TEST(TetArap, PassesTheLinearPatchTest) {
  const TetMesh even = tet_blocks(4, 4, 4);
  Positions positions = even.positions();
  const Positions noise = Random(3).noise(even.n_vertices(), .03);
  Matrix3 A;
  A << 1.2, .1, 0, .1, 1.1, .05, 0, .05, 1.3;
  Task task;
  const double least = positions.minCoeff();
  const double most = positions.maxCoeff();
  for (int v = 0; v < even.n_vertices(); ++v)
    if ((positions.row(v).array() == least).any() || (positions.row(v).array() == most).any())
      task.add(v, A * positions.row(v).transpose());
    else
      positions.row(v) += noise.row(v);
  const TetMesh mesh(positions, even.tets());
  EXPECT_LT(max_distance(solve(mesh, task, 1e-10).positions, mesh.positions() * A.transpose()), 1e-9);
}

TEST(TetArap, ConvergesWhereTheGradientIsZeroAtFreeVertices) {
  const TetMesh mesh = uneven_bar();
  const Task task = bend(mesh, some_motion());
  TetArap solver(mesh);
  solver.set_constraints(task.constraints);
  const SolveResult result = solver.solve(task.targets, to_accuracy(1e-10));
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  EXPECT_NEAR(result.energy_after, energy_of(mesh, result.positions), 1e-12);
  Positions gradient = solver.energy_gradient(result.positions);
  for (const int v : task.constraints.vertices) gradient.row(v).setZero();
  EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-8);
}

TEST(TetArap, HardVerticesAreAtTheirTargets) {
  const TetMesh mesh = uneven_bar();
  const Task task = bend(mesh, some_motion());
  EXPECT_LT(max_distance(values_of(task.constraints, solve(mesh, task).positions), task.targets), 1e-14);
}

TEST(TetArap, SoftVerticesGiveWay) {
  const TetMesh mesh = uneven_bar();
  const RigidMotion pull{Matrix3::Identity(), {.3, 0, 0}};
  const int tip = far_end(mesh).back();
  double before = 0;
  for (const double strength : {.05, .5, .95, 1.0}) {
    const Positions p = solve(mesh, bend(mesh, pull, strength)).positions;
    const double way = p(tip, 0) - mesh.positions()(tip, 0);
    EXPECT_GT(way, before) << strength;
    before = way;
  }
  EXPECT_NEAR(before, .3, 1e-14);
}

TEST(TetArap, APointInATetrahedronIsAPatch) {
  const TetMesh mesh = uneven_bar();
  Task task = bend(mesh, {});
  task.constraints.vertices.resize(low_end(mesh).size());
  task.constraints.strengths.resize(task.constraints.vertices.size());
  task.targets.conservativeResize(static_cast<Eigen::Index>(task.constraints.vertices.size()), 3);
  const TetMesh::Tet& tet = mesh.tets().back();
  const std::vector<double> weights{.1, .2, .3, .4};
  const Vector3 target = average(mesh.positions(), tet, weights) + Vector3(-.1, .2, .1);
  task.add_patch({tet.begin(), tet.end()}, weights, target);
  EXPECT_LT((average(solve(mesh, task).positions, tet, weights) - target).norm(), 1e-12);
}

TEST(TetArap, ARigidRegionIsExactlyRigid) {
  const TetMesh mesh = uneven_bar();
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  std::vector<int> members;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.positions()(v, 0) - .4) < .2) {
      regions[v] = 3;
      members.push_back(v);
    }
  for (const auto* factory : {kOwnSolver, exact_solver()}) {
    TetOptions options;
    options.solver_factory = factory;
    const Task task = bend(mesh, some_motion());
    const SolveResult result = solve(mesh, task, 1e-9, options, {{}, regions});
    EXPECT_LT(off_rigid(mesh.positions(), result.positions, members), 1e-12);
    EXPECT_GT(off_rigid(mesh.positions(), solve(mesh, task).positions, members), 1e-3) << "the test bends it";
    EXPECT_NEAR(result.energy_after, energy_of(mesh, result.positions), 1e-12);
  }
}

/// Between two regions without a free vertex, a tetrahedron turns with one of them.
TEST(TetArap, RegionsSideBySideAreEachRigid) {
  const TetMesh mesh = uneven_bar();
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  std::vector<std::vector<int>> members(2);
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const double x = mesh.positions()(v, 0);
    if (x < .25 || x > .55) continue;
    regions[v] = x < .4 ? 0 : 1;
    members[regions[v]].push_back(v);
  }
  const Positions p = solve(mesh, bend(mesh, some_motion()), 1e-9, {}, {{}, regions}).positions;
  for (const std::vector<int>& of_region : members) EXPECT_LT(off_rigid(mesh.positions(), p, of_region), 1e-12);
  std::vector<int> both = members[0];
  both.insert(both.end(), members[1].begin(), members[1].end());
  EXPECT_GT(off_rigid(mesh.positions(), p, both), 1e-3);
}

TEST(TetArap, ARegionOfOneVertexIsNone) {
  const TetMesh mesh = uneven_bar();
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (v % 3 != 0) regions[v] = v;
  const Task task = bend(mesh, some_motion());
  EXPECT_EQ(solve(mesh, task, 1e-9, {}, {{}, regions}).positions, solve(mesh, task).positions);
}

TEST(TetArap, TetrahedraInsideOutAreTheSame) {
  const TetMesh mesh = uneven_bar();
  std::vector<TetMesh::Tet> flipped = mesh.tets();
  for (size_t t = 0; t < flipped.size(); t += 2) std::swap(flipped[t][t % 3], flipped[t][3]);
  const Task task = bend(mesh, some_motion());
  const SolveResult expected = solve(mesh, task, 1e-10);
  const SolveResult result = solve(TetMesh(mesh.positions(), flipped), task, 1e-10);
  EXPECT_LT(max_distance(result.positions, expected.positions), 1e-9);
  EXPECT_NEAR(result.energy_after, expected.energy_after, 1e-13);
}

TEST(TetArap, LosesNoDigitsFarFromTheOrigin) {
  const Vector3 away(1 << 20, -(1 << 21), 1 << 19);
  // Coordinates that the far ones have exactly.
  const TetMesh near =
      transformed(uneven_bar(), [](const Vector3& x) { return Vector3((x * (1 << 30)).array().round() / (1 << 30)); });
  const TetMesh far = transformed(near, [&](const Vector3& x) { return Vector3(x + away); });
  Task task = bend(near, some_motion());
  task.targets = (task.targets * (1 << 30)).array().round() / (1 << 30);
  const Positions expected = solve(near, task, 1e-10).positions;
  task.targets.rowwise() += away.transpose();
  const Positions moved = solve(far, task, 1e-10).positions;
  EXPECT_LT(max_distance(moved.rowwise() - away.transpose(), expected), 2e-9);
}

TEST(TetArap, FlatTetrahedraServe) {
  for (const double height : {1e-3, 1e-6}) {
    const TetMesh mesh =
        transformed(tet_blocks(6, 3, 3), [&](const Vector3& x) { return Vector3(x[0], x[1], height * x[2]); });
    const Task task = bend(mesh, {rotation_about({0, 0, 1}, .5), {0, .1, 0}});
    const SolveResult result = solve(mesh, task, 1e-6);
    EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged) << height;
    EXPECT_LE(result.energy_after, result.energy_before) << height;
    EXPECT_LT(max_distance(values_of(task.constraints, result.positions), task.targets), 1e-14) << height;
  }
}

TEST(TetArap, IsTheSameOnEveryNumberOfThreads) {
  const TetMesh mesh = uneven_bar(24, 10);  // single precision serves it
  const Task task = bend(mesh, some_motion());
  for (const double accuracy : {1e-5, 1e-9}) {
    const SolveResult one = solve(mesh, task, accuracy, with_threads(1));
    const SolveResult two = solve(mesh, task, accuracy, with_threads(2));
    EXPECT_LT(max_distance(two.positions, one.positions), 2 * accuracy);
    EXPECT_EQ(solve(mesh, task, accuracy, with_threads(2)).positions, two.positions);
  }
  EXPECT_EQ(TetArap(mesh, with_threads(2)).threads(), 2);
}

TEST(TetArap, EverySolverEndsAtTheSamePose) {
  const TetMesh mesh = uneven_bar();
  const Task task = bend(mesh, some_motion());
  const Positions expected = solve(mesh, task, 1e-10).positions;
  for (const auto kind : {arap::ReferenceSolver::kSimplicialLdlt, arap::ReferenceSolver::kSparseLu,
                          arap::ReferenceSolver::kSparseQr, arap::ReferenceSolver::kBiCgStab}) {
    TetOptions options;
    options.solver_factory = &arap::reference_solver(kind);
    EXPECT_LT(max_distance(solve(mesh, task, 1e-10, options).positions, expected), 1e-8);
  }
}

TEST(TetArap, HasTheActsOfASurface) {
  const TetMesh mesh = uneven_bar();
  const Task task = bend(mesh, some_motion());
  TetArap solver(mesh);
  EXPECT_EQ(solver.n_vertices(), mesh.n_vertices());
  EXPECT_EQ(solver.n_parts(), 1);
  EXPECT_EQ(solver.n_factorizations(), 0);
  solver.set_constraints(task.constraints);
  solver.set_constraints(task.constraints);
  EXPECT_EQ(solver.n_factorizations(), 1);
  const Positions posed = solver.solve(task.targets, to_accuracy(1e-9)).positions;
  EXPECT_EQ(solver.positions(), posed);
  EXPECT_EQ(solver.n_factorizations(), 1);
  solver.reset();
  EXPECT_LT(max_distance(solver.positions(), mesh.positions()), 1e-15);
  solver.set_positions(posed);
  EXPECT_LT(max_distance(solver.positions(), posed), 1e-15);
  EXPECT_LE(solver.solve(task.targets, to_accuracy(1e-9)).iterations, 10);
  std::vector<float> out(3 * static_cast<size_t>(mesh.n_vertices()));
  const SolveResult result = solver.solve(task.targets, to_accuracy(1e-9), {}, {}, out);
  EXPECT_EQ(result.positions.rows(), 0);
  EXPECT_NEAR(out[0], posed(0, 0), 1e-6);
  const SolveResult cancelled = solver.solve(1.1 * task.targets, to_accuracy(1e-9), {}, [](double) { return false; });
  EXPECT_EQ(cancelled.stop_reason, arap::StopReason::kCancelled);
  TetArap moved = std::move(solver);
  EXPECT_LT(max_distance(moved.positions(), posed), 1e-7);
}

TEST(TetArap, PartsWithoutConstraintsAndLooseVerticesStayAtRest) {
  const TetMesh bar = uneven_bar(4, 2);
  const int n = bar.n_vertices();
  Positions positions(2 * n + 1, 3);
  positions << 40, 50, 60, bar.positions(), bar.positions().array() + 2;
  std::vector<TetMesh::Tet> tets;
  for (const int first : {1, n + 1})
    for (TetMesh::Tet tet : bar.tets()) {
      for (int& v : tet) v += first;
      tets.push_back(tet);
    }
  const TetMesh mesh(positions, tets);
  Task task;
  for (const int v : low_end(bar)) task.add(v + 1, bar.positions().row(v));
  for (const int v : far_end(bar)) task.add(v + 1, some_motion().apply(Vector3(bar.positions().row(v))));
  const SolveResult result = solve(mesh, task, 1e-10);
  EXPECT_LT(max_distance(result.positions.middleRows(1, n), solve(bar, bend(bar, some_motion()), 1e-10).positions),
            1e-8);
  EXPECT_LT(max_distance(result.positions.bottomRows(n), mesh.positions().bottomRows(n)), 1e-14);
  EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
  EXPECT_EQ(result.loose_vertices, std::vector<int>{0});
  EXPECT_LT((result.positions.row(0) - Eigen::RowVector3d(40, 50, 60)).norm(), 1e-14);
  task.add(0, {41, 50, 60}, .3);
  EXPECT_LT((solve(mesh, task).positions.row(0) - Eigen::RowVector3d(41, 50, 60)).norm(), 1e-12);
}

TEST(TetArapErrors, SayWhatIsWrong) {
  const TetMesh mesh = uneven_bar(2, 1);
  const auto n = static_cast<size_t>(mesh.n_vertices());
  using arap::InvalidInput;
  expect_error<InvalidInput>([&] { const TetArap solver(mesh, with_threads(-1)); }, {"threads = -1", "0", "1024"});
  expect_error<InvalidInput>([&] { const TetArap solver(mesh, {}, {{1, 1}, {}}); }, {"stiffness", "2", "12"});
  std::vector<double> stiffness(n, 1);
  stiffness[5] = 0;
  expect_error<InvalidInput>([&] { const TetArap solver(mesh, {}, {stiffness, {}}); }, {"stiffness", "vertex 5"});
  expect_error<InvalidInput>([&] { const TetArap solver(mesh, {}, {{}, {0}}); }, {"rigid_regions", "1", "12"});
  expect_error<arap::Cancelled>([&] { const TetArap solver(mesh, {}, {}, [](double) { return false; }); },
                                {"binding was cancelled"});
  TetArap solver(mesh);
  expect_error<InvalidInput>([&] { solver.solve(mesh.positions()); }, {"nothing is constrained", "set_constraints"});
  expect_error<InvalidInput>([&] { solver.set_constraints({{99}, {}, {}}); }, {"99"});
  expect_error<InvalidInput>([&] { solver.set_positions(Positions::Zero(3, 3)); }, {"positions", "3", "12"});
  expect_error<InvalidInput>([&] { static_cast<void>(solver.energy(Positions::Zero(3, 3))); }, {"positions", "3"});
  const TetMesh huge = transformed(mesh, [](const Vector3& x) { return Vector3(1e99 * x); });
  TetArap stiff(huge, {}, {std::vector<double>(n, 1e12), {}});
  expect_error<arap::SolverError>([&] { static_cast<void>(stiff.energy(5 * huge.positions())); },
                                  {"too large", "sizes of the mesh away"});
  Positions with_dust(mesh.n_vertices() + 4, 3);
  with_dust << mesh.positions(), Eigen::RowVector3d::Zero(), 1e-20 * Matrix3::Identity();
  std::vector<TetMesh::Tet> tets = mesh.tets();
  tets.push_back({12, 13, 14, 15});
  expect_error<InvalidInput>([&] { const TetArap dust(TetMesh(with_dust, tets)); },
                             {"tetrahedron 12", "so small beside the mesh", "enlarge or remove"});
  Positions with_loose(mesh.n_vertices() + 1, 3);
  with_loose << mesh.positions(), 9, 9, 9;
  TetArap loose(TetMesh(with_loose, mesh.tets()));
  expect_error<InvalidInput>(
      [&] {
        loose.set_constraints({{}, {}, {{0, 2}, {0, 12}, {.5, .5}}});
      },
      {"patch 0", "loose vertex 12", "leave it out"});
}

}  // namespace
}  // namespace arap_test
