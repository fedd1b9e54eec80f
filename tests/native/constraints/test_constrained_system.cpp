// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/constrained_system.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "cholesky/solver_choice.h"
#include "sparse/sparse.h"
#include "support/dense.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Cancelled;
using arap::ConstrainedSystem;
using arap::InitialGuess;
using arap::LinearRow;
using arap::SolveResult;
using arap::SparseMatrix;
using arap::SurfaceArap;

// The system alone: against the dense saddle system.

std::unique_ptr<arap::LinearSolver> make_solver(const SparseMatrix& pattern, const arap::SolverFactory* factory) {
  return arap::make_linear_solver(pattern, arap::Workers(1), arap::TileFormat::kHalf, {}, factory);
}

struct Problem {
  SparseMatrix K;
  std::vector<char> is_fixed;
  Eigen::VectorXd soft_diagonal;
  std::vector<LinearRow> averages;
  arap::LinearRows soft_rows;
  arap::LinearRows stiff_rows;

  explicit Problem(const MeshData& mesh)
      : K(Reference(mesh, arap::Energy::kSpokes, arap::EdgeWeights::kCotangent).matrix().sparseView()),
        is_fixed(static_cast<size_t>(mesh.n_vertices()), 0),
        soft_diagonal(Eigen::VectorXd::Zero(mesh.n_vertices())) {}

  [[nodiscard]] arap::SystemConstraints constraints() const {
    return {is_fixed, soft_diagonal, averages, soft_rows, stiff_rows};
  }

  [[nodiscard]] static Eigen::MatrixXd dense(const arap::LinearRows& rows, Eigen::Index n) {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows.size(), n);
    for (int r = 0; r < rows.size(); ++r)
      for (size_t k = 0; k < rows.rows[r].indices.size(); ++k)
        result(r, rows.rows[r].indices[k]) += rows.rows[r].coefficients[k];
    return result;
  }
  /// Averages, then stiff rows.
  [[nodiscard]] Eigen::MatrixXd dense_held() const {
    arap::LinearRows held;
    for (const LinearRow& average : averages) held.add(average, 1);
    for (const LinearRow& row : stiff_rows.rows) held.add(row, 1);
    return dense(held, K.rows());
  }
  /// H^T W H.
  [[nodiscard]] static Eigen::MatrixXd normal_matrix(const arap::LinearRows& rows, Eigen::Index n) {
    const Eigen::MatrixXd H = dense(rows, n);
    return H.transpose() * Eigen::VectorXd::Map(rows.weights.data(), rows.size()).asDiagonal() * H;
  }

  /// Minimizer of 1/2 <x, A x> - <b, x>, fixed rows as in `x`; the targets of averages, then of stiff rows.
  [[nodiscard]] Positions dense_solution(const Positions& b, const Positions& x, const Positions& targets) const {
    const auto n = K.rows();
    const auto m = static_cast<Eigen::Index>(averages.size());
    Eigen::MatrixXd saddle = Eigen::MatrixXd::Zero(n + m, n + m);
    Eigen::MatrixXd right(n + m, 3);
    saddle.topLeftCorner(n, n) = Eigen::MatrixXd(K) + Eigen::MatrixXd(soft_diagonal.asDiagonal()) +
                                 normal_matrix(soft_rows, n) + normal_matrix(stiff_rows, n);
    right << b, targets.topRows(m);
    right.topRows(n) += dense(stiff_rows, n).transpose() *
                        Eigen::VectorXd::Map(stiff_rows.weights.data(), stiff_rows.size()).asDiagonal() *
                        targets.bottomRows(stiff_rows.size());
    for (Eigen::Index k = 0; k < m; ++k)
      for (size_t e = 0; e < averages[k].indices.size(); ++e)
        saddle(n + k, averages[k].indices[e]) += averages[k].coefficients[e];
    saddle.topRightCorner(n, m) = saddle.bottomLeftCorner(m, n).transpose();
    for (Eigen::Index v = 0; v < n; ++v) {
      if (is_fixed[v] == 0) continue;
      saddle.row(v).setZero();
      saddle(v, v) = 1;
      right.row(v) = x.row(v);
    }
    return solver_of(saddle)(right).topRows(n);
  }

  void expect_solved(const std::string& what) const {
    for (const auto* factory : {exact_solver(), kOwnSolver}) expect_solved_by(factory, what);
  }

  void expect_solved_by(const arap::SolverFactory* factory, const std::string& what) const {
    const auto n = static_cast<int>(K.rows());
    const Positions b = Random(71).noise(n, 1);
    const Positions x = Random(72).noise(n, 1);
    const Positions targets = Random(73).noise(static_cast<int>(averages.size()) + stiff_rows.size(), 1);
    const auto solver = make_solver(K, factory);
    const ConstrainedSystem system(*solver, factory, K, arap::connected_components(K), constraints(), {});
    Positions residual;
    system.multiply(x, residual);
    residual = b - residual;
    Positions gaps = targets;
    for (size_t k = 0; k < averages.size(); ++k) gaps.row(k) -= averages[k].of(x);
    gaps.bottomRows(stiff_rows.size()) -= dense(stiff_rows, n) * x;
    Positions multipliers;
    Positions exact = residual;
    system.correct_to(1e-14, exact, gaps);
    system.correct(residual, gaps, multipliers, residual);
    const Positions expected = dense_solution(b, x, targets);
    const double size = 1 + expected.cwiseAbs().maxCoeff();
    EXPECT_LT(max_distance(x + exact, expected), 1e-8 * size) << what;
    // Stiff rows are met by iteration, and a rounded factor does not find the end at once.
    const bool is_exact = stiff_rows.empty() && factory != kOwnSolver;
    EXPECT_LT(max_distance(x + residual, expected), (is_exact ? 1e-9 : 1e-2) * size) << what;
    for (size_t k = 0; k < averages.size(); ++k)
      EXPECT_LT((averages[k].of(x + residual) - targets.row(static_cast<int>(k))).norm(), 1e-12 * size) << what;
  }
};

TEST(ConstrainedSystem, FixedSoftAndAveragesInOneComponent) {
  Problem fixed(bumpy_sphere(1));
  fixed.is_fixed[3] = fixed.is_fixed[17] = 1;
  fixed.expect_solved("fixed");
  Problem soft(bumpy_sphere(1));
  soft.soft_diagonal[3] = 2;
  soft.soft_diagonal[30] = .01;
  soft.expect_solved("soft alone");
  Problem beside(bumpy_sphere(1));
  beside.is_fixed[3] = 1;
  beside.soft_diagonal[12] = 3;
  beside.averages = {{{5, 6, 7}, {.5, .25, .25}}, {{3, 8, 9}, {.2, .4, .4}}, {{20}, {1}}};
  beside.expect_solved("averages, one with a fixed member, beside fixed and soft");
  // Without a fixed unknown the right-hand side must sum to what the averages take, which it does by their multipliers.
  Problem averages(bumpy_sphere(1));
  averages.averages = {{{5, 6, 7}, {.5, .25, .25}}};
  averages.expect_solved("one average alone");
  averages.averages.insert(averages.averages.end(), {{{30, 31}, {.5, .5}}, {{6, 12}, {.1, .9}}});
  averages.expect_solved("three averages alone, two that overlap");
}

// Of averages alone, whose multipliers have another unit than the place of the component.
TEST(ConstrainedSystem, TheStiffnessOfTheWholeDoesNotMatter) {
  Problem problem(bumpy_sphere(1));
  problem.averages = {{{5, 6, 7}, {.5, .25, .25}}, {{30, 31}, {.5, .5}}, {{6, 12}, {.1, .9}}};
  const auto n = static_cast<int>(problem.K.rows());
  const auto solved = [&](const arap::SolverFactory* factory, double stiffness) {
    const SparseMatrix K = stiffness * problem.K;
    const auto solver = make_solver(K, factory);
    const ConstrainedSystem system(*solver, factory, K, arap::connected_components(K), problem.constraints(), {});
    Positions x = stiffness * Random(71).noise(n, 1);
    system.correct_to(1e-14, x, Random(73).noise(3, 1));
    return x;
  };
  for (const auto* factory : {exact_solver(), kOwnSolver})
    EXPECT_LT(max_distance(solved(factory, 1e14), solved(factory, 1)), 1e-8);
}

TEST(ConstrainedSystem, EachComponentIsHeldItsOwnWay) {
  const MeshData mesh = join(two_spheres(0), bumpy_sphere(0));
  Problem problem(mesh);
  problem.is_fixed[2] = 1;
  problem.averages = {{{13, 14}, {.5, .5}}, {{3, 15}, {.5, .5}}};
  problem.soft_diagonal[30] = 1;
  problem.expect_solved("three parts: fixed, averages, soft; one average over two of them");
}

TEST(ConstrainedSystem, SoftRowsBesideFixedAndSoftUnknownsAndAverages) {
  Problem problem(bumpy_sphere(1));
  problem.is_fixed[3] = 1;
  problem.soft_diagonal[12] = 3;
  problem.soft_rows.add({{5, 30, 17}, {1, -.5, 2}}, .7);
  problem.soft_rows.add({{3, 31}, {.5, .5}}, 4);
  problem.soft_rows.add({{8}, {1}}, .1);
  problem.expect_solved("soft rows");
  problem.averages = {{{5, 6, 7}, {.5, .25, .25}}};
  problem.expect_solved("and an average");
}

TEST(ConstrainedSystem, SoftRowsAloneHoldAComponent) {
  Problem problem(bumpy_sphere(1));
  problem.soft_rows.add({{5, 30}, {.5, .5}}, .7);
  problem.expect_solved("a row");
}

TEST(ConstrainedSystem, RowsOverTwoComponentsHoldBoth) {
  Problem problem(join(two_spheres(0), bumpy_sphere(0)));
  problem.is_fixed[2] = 1;
  problem.soft_rows.add({{3, 15}, {1, -1}}, 2);
  problem.soft_rows.add({{14, 30}, {1, 1}}, .5);
  problem.expect_solved("a chain of three parts, the first fixed");
}

TEST(ConstrainedSystem, RowsThatDoNotSayWhereAComponentIsLeaveThatToOthers) {
  Problem problem(bumpy_sphere(1));
  problem.soft_rows.add({{5, 30}, {1, -1}}, 2);
  problem.averages = {{{20, 21}, {.5, .5}}};
  problem.expect_solved("a difference, and an average");
}

TEST(ConstrainedSystem, StiffRows) {
  Problem problem(bumpy_sphere(1));
  for (int k = 0; k < 6; ++k) problem.stiff_rows.add({{k, 2 * k + 11, 40 - k}, {.5, .3, .2}}, 1e5);
  problem.expect_solved("alone");
  problem.is_fixed[3] = 1;
  problem.soft_rows.add({{8, 9}, {.5, .5}}, 1);
  problem.expect_solved("with a fixed unknown among theirs, and a soft row");
  problem.averages = {{{6, 7}, {.5, .5}}, {{20}, {1}}};
  problem.expect_solved("and averages");
}

TEST(ConstrainedSystem, StiffRowsMayRepeatAndContradictEachOther) {
  Problem problem(bumpy_sphere(1));
  problem.is_fixed[0] = 1;
  for (int copy = 0; copy < 3; ++copy) problem.stiff_rows.add({{5, 30}, {.5, .5}}, 1e5 * (1 + copy));
  problem.stiff_rows.add({{5, 30, 31}, {1, 1, 1}}, 1e5);
  problem.stiff_rows.add({{31}, {1}}, 1e5);
  problem.expect_solved("five rows over two degrees of freedom, each with its own target");
}

TEST(ConstrainedSystem, MultipliersAreTheForcesOfAveragesAndStiffRows) {
  Problem problem(bumpy_sphere(1));
  problem.is_fixed[3] = 1;
  problem.averages = {{{8, 9}, {.5, .5}}};
  problem.stiff_rows.add({{5, 30}, {.5, .5}}, 3000);
  problem.stiff_rows.add({{17}, {1}}, 1e6);
  const ConstrainedSystem system(*make_solver(problem.K, exact_solver()), exact_solver(), problem.K,
                                 arap::connected_components(problem.K), problem.constraints(), {});
  const Positions b = Random(71).noise(static_cast<int>(problem.K.rows()), 1);
  const Positions targets = Random(73).noise(3, 1);
  Positions x = Positions::Zero(b.rows(), 3);
  Positions multipliers;
  Positions correction;
  for (int n = 0; n < 20; ++n) {
    Positions gaps = targets - problem.dense_held() * x;
    system.correct(b - problem.K * x, gaps, multipliers, correction);
    x += correction;
  }
  Positions left = b - problem.K * x - problem.dense_held().transpose() * multipliers;
  left.row(3).setZero();
  EXPECT_LT(left.cwiseAbs().maxCoeff(), 1e-7);
}

TEST(ConstrainedSystem, DifferencesAloneDoNotCarryComponentsAway) {
  Problem one(bumpy_sphere(3));
  one.averages = {{{5, 300}, {1e-4, -1e-4}}};
  Problem chain(join(two_spheres(2), bumpy_sphere(2)));
  const int n = static_cast<int>(chain.K.rows()) / 3;
  chain.averages = {{{3, n + 3}, {1, -1}}, {{n + 8, 2 * n + 8}, {1e-4, -1e-4}}};
  Problem soft = chain;
  soft.averages.pop_back();
  soft.soft_rows.add({{n + 8, 2 * n + 8}, {.3, -.3}}, 2);
  for (const Problem& problem : {one, chain, soft})
    for (const auto* factory : {exact_solver(), kOwnSolver}) {
      const ConstrainedSystem system(*make_solver(problem.K, factory), factory, problem.K,
                                     arap::connected_components(problem.K), problem.constraints(), {});
      // Nothing pulls at the components as a whole.
      Positions residual = Random(71).noise(static_cast<int>(problem.K.rows()), 1);
      residual.rowwise() -= residual.colwise().mean().eval();
      const Positions gaps = Random(73).noise(static_cast<int>(problem.averages.size()), 1e-4);
      Positions multipliers;
      system.correct(residual, gaps, multipliers, residual);
      EXPECT_LT(max_distance(problem.dense_held() * residual, gaps), 1e-5);
      EXPECT_LT(residual.cwiseAbs().maxCoeff(), 100);
    }
}

TEST(ConstrainedSystem, CorrectionOfASolutionIsZero) {
  Problem problem(bumpy_sphere(1));
  problem.is_fixed[0] = 1;
  const auto solver = make_solver(problem.K, exact_solver());
  const ConstrainedSystem system(*solver, exact_solver(), problem.K, arap::connected_components(problem.K),
                                 problem.constraints(), {});
  Positions residual = Positions::Zero(problem.K.rows(), 3);
  Positions multipliers;
  system.correct(residual, Positions(0, 3), multipliers, residual);
  EXPECT_EQ(residual.norm(), 0);
}

/// Counts solves.
class CountedFactorization final : public arap::Factorization {
 public:
  CountedFactorization(std::unique_ptr<arap::Factorization> factor, int& n_solves)
      : factor_(std::move(factor)), n_solves_(n_solves) {}

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override {
    ++n_solves_;
    factor_->solve(b, x);
  }
  [[nodiscard]] std::unique_ptr<arap::Border> border(const SparseMatrix& columns,
                                                     const arap::MeterPart& meter) const override {
    return factor_->border(columns, meter);
  }

 private:
  std::unique_ptr<arap::Factorization> factor_;
  int& n_solves_;
};

class CountedSolver final : public arap::LinearSolver {
 public:
  CountedSolver(const SparseMatrix& pattern, int& n_solves)
      : solver_(arap::make_linear_solver(pattern)), n_solves_(n_solves) {}

  [[nodiscard]] std::unique_ptr<arap::Factorization> factorize(const SparseMatrix& A,
                                                               const std::vector<char>& is_erased,
                                                               const arap::MeterPart& meter) const override {
    return std::make_unique<CountedFactorization>(solver_->factorize(A, is_erased, meter), n_solves_);
  }

 private:
  std::unique_ptr<arap::LinearSolver> solver_;
  int& n_solves_;
};

TEST(ConstrainedSystem, ToSetAveragesTakesNoSolves) {
  Problem problem(bumpy_sphere(2));
  problem.is_fixed[0] = 1;
  for (int k = 1; k <= 90; ++k) problem.averages.push_back({{k, k + 9}, {.5, .5}});
  int n_solves = 0;
  const CountedSolver solver(problem.K, n_solves);
  const ConstrainedSystem system(solver, kOwnSolver, problem.K, arap::connected_components(problem.K),
                                 problem.constraints(), {});
  EXPECT_EQ(n_solves, 0);
}

TEST(ConstrainedSystem, ManyAveragesReportProgressAndMayBeCancelled) {
  Problem problem(bumpy_sphere(1));
  problem.is_fixed[0] = 1;
  for (int k = 1; k <= 9; ++k) problem.averages.push_back({{k, k + 9}, {.5, .5}});
  const auto solver = arap::make_linear_solver(problem.K);
  const auto build = [&](const arap::Progress& progress) {
    const ConstrainedSystem system(*solver, kOwnSolver, problem.K, arap::connected_components(problem.K),
                                   problem.constraints(), progress);
  };
  std::vector<double> fractions;
  build([&](double fraction) {
    fractions.push_back(fraction);
    return true;
  });
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1);
  EXPECT_THROW(build([](double fraction) { return fraction < .85; }), Cancelled);
}

// Patches through the whole model.

/// The vertices within `radius` of one, with weights that fall to 0 there.
void add_disc(Task& task, const MeshData& mesh, int centre, double radius, const Vector3& move) {
  std::vector<int> vertices;
  std::vector<double> weights;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const double d = (mesh.vertices[v] - mesh.vertices[centre]).norm() / radius;
    if (d >= 1) continue;
    vertices.push_back(v);
    weights.push_back(std::pow(1 - d * d, 3));
  }
  task.add_patch(vertices, weights, average(mesh.positions(), vertices, weights) + move);
}

/// How far the averages are from their targets.
double patch_gap(const Task& task, const Positions& p) {
  const int n = task.constraints.patches.size();
  return max_distance(values_of(task.constraints, p).bottomRows(n), task.targets.bottomRows(n));
}

TEST(Patches, AverageMeetsItsTargetAfterEveryIteration) {
  for (const MeshData& mesh : {bumpy_sphere(2), cylinder(12, 8), bar(3, Faces::kQuads)}) {
    Task task = hold(mesh, extreme_vertices(mesh.positions(), longest_axis(mesh.positions()), .1));
    add_disc(task, mesh, mesh.n_vertices() - 1, .3 * mesh.diagonal(), Vector3(.1, .2, .1) * mesh.diagonal());
    SurfaceArap solver(mesh.mesh());
    solver.set_constraints(task.constraints);
    for (const InitialGuess guess :
         {InitialGuess::kRest, InitialGuess::kPrevious, InitialGuess::kNaiveLaplacian, InitialGuess::kHandleRotations})
      for (const int n : {1, 2, 10})
        EXPECT_LT(patch_gap(task, solver.solve(task.targets, iterations(n, guess)).positions), 1e-9 * mesh.diagonal())
            << mesh.name;
  }
}

TEST(Patches, WeightsAreScaledToSumOne) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, {0, 1, 2});
  Task scaled = task;
  task.add_patch({30, 31, 32}, {.5, .25, .25}, {0, 0, 2});
  scaled.add_patch({30, 31, 32}, {2e3, 1e3, 1e3}, {0, 0, 2});
  EXPECT_LT(
      max_distance(solve_once(mesh, task, iterations(5)).positions, solve_once(mesh, scaled, iterations(5)).positions),
      1e-12);
}

TEST(Patches, ConvergeWhereTheReferenceDoes) {
  for (const Model& model : all_models()) {
    for (const MeshData& mesh : {bumpy_sphere(1), l_prism(4)}) {
      Task task = hold(mesh, extreme_vertices(mesh.positions(), 2, .2));
      // At the rim: the reference does not know what the others cut off.
      task.constraints.strengths.back() = .5;
      add_disc(task, mesh, extreme_vertices(mesh.positions(), 2, -.01).front(), .5 * mesh.diagonal(), {.3, .2, .1});
      add_disc(task, mesh, mesh.n_vertices() / 2, .3 * mesh.diagonal(), {0, .2, 0});
      expect_ends_at_reference(mesh, task, model);
    }
    const MeshData mesh = bumpy_sphere(1);
    Task soft;
    for (const int v : {0, 7, 12, 33}) soft.add(v, mesh.vertices[v] + Vector3(.1, 0, .2), .3);
    add_disc(soft, mesh, 40, .6, {.4, 0, 0});
    expect_ends_at_reference(mesh, soft, model);
  }
}

TEST(Patches, OnePatchAloneMovesThePartAsItIs) {
  for (const MeshData& mesh : {bumpy_sphere(2), cylinder(12, 8)}) {
    Task task;
    const Vector3 move = Vector3(1, -2, .5);
    add_disc(task, mesh, 0, .3 * mesh.diagonal(), move);
    const SolveResult result = solve_once(mesh, task, iterations(3));
    EXPECT_LT(max_distance(result.positions, RigidMotion{Matrix3::Identity(), move}.apply(mesh.positions())),
              1e-9 * mesh.diagonal());
    EXPECT_NEAR(result.energy_after, 0, 1e-12);
    EXPECT_TRUE(result.parts_at_rest.empty());
  }
}

TEST(Patches, SeveralPatchesAloneMovedByOneRigidMotionMoveThePartByIt) {
  const MeshData mesh = bumpy_sphere(2);
  const RigidMotion motion = Random(74).rigid_motion(.7, 1);
  Task task;
  for (const int centre : {0, 3, 6, 9}) add_disc(task, mesh, centre, .3, Vector3::Zero());
  task = rigid_task(mesh, task.constraints, motion);
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-9));
  EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-6 * mesh.diagonal());
  const std::vector<Matrix3> rotations(4, motion.rotation);
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  const SolveResult guessed = solver.solve(task.targets, iterations(1, InitialGuess::kHandleRotations), rotations);
  EXPECT_LT(max_distance(guessed.positions, motion.apply(mesh.positions())), 1e-7 * mesh.diagonal());
}

TEST(Patches, MayHoldHardVerticesAndOverlap) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, {0, 1});
  task.add_patch({0, 20, 30}, {1, 1, 1}, {.2, .2, .2});
  task.add_patch({20, 30, 32}, {1, 2, 1}, {-.2, .2, .2});
  const SolveResult result = solve_once(mesh, task, iterations(5));
  EXPECT_LT(patch_gap(task, result.positions), 1e-9);
  EXPECT_EQ(result.positions.row(0), mesh.positions().row(0));
}

TEST(Patches, OfOneAverageTwiceMeetInTheMiddle) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, {0, 1, 2});
  task.add_patch({30, 31}, {1, 1}, {1, 0, 0});
  task.add_patch({30, 31}, {2, 2}, {0, 1, 0});
  // Rounding of a system without an inverse; it depends on the processor.
  constexpr double kRounding = 1e-8;
  for (const int n : {1, 5}) {
    const Positions p = solve_once(mesh, task, iterations(n)).positions;
    EXPECT_LT(((p.row(30) + p.row(31)) / 2 - Eigen::RowVector3d(.5, .5, 0)).norm(), kRounding) << n;
  }
}

/// Patches all over a mesh, some of which overlap, two are one, and nothing else.
Task many_patches(const MeshData& mesh, int n) {
  Task task;
  Random random(75);
  for (int k = 0; k < n; ++k)
    add_disc(task, mesh, static_cast<int>(random.uniform(0, mesh.n_vertices())), random.uniform(.05, .3),
             Vector3(random.uniform(-.1, .1), random.uniform(-.1, .1), random.uniform(-.1, .1)));
  return task;
}

TEST(Patches, ManyAreHeldAfterEveryIteration) {
  const MeshData mesh = bumpy_sphere(4);
  for (const bool is_pinned : {false, true}) {
    Task task = many_patches(mesh, 80);
    if (is_pinned) {
      const Positions targets = task.targets;
      const Task pins = hold(mesh, {0, 1, 2});
      task.constraints.vertices = pins.constraints.vertices;
      task.constraints.strengths = pins.constraints.strengths;
      task.targets.resize(targets.rows() + pins.targets.rows(), 3);
      task.targets << pins.targets, targets;
    }
    SurfaceArap solver(mesh.mesh());
    solver.set_constraints(task.constraints);
    for (const int n : {1, 2, 10})
      EXPECT_LT(patch_gap(task, solver.solve(task.targets, iterations(n)).positions), 1e-8 * mesh.diagonal());
  }
}

TEST(Patches, TheirOrderDoesNotMatterNorDoThreads) {
  const MeshData mesh = bumpy_sphere(4);
  const Task task = many_patches(mesh, 40);
  Task reversed;
  const arap::Patches& patches = task.constraints.patches;
  for (int p = patches.size() - 1; p >= 0; --p) {
    const auto begin = patches.offsets[p];
    const auto end = patches.offsets[p + 1];
    reversed.constraints.patches.add({{patches.vertices.begin() + begin, patches.vertices.begin() + end},
                                      {patches.weights.begin() + begin, patches.weights.begin() + end}});
  }
  reversed.targets = task.targets.colwise().reverse();
  Positions expected;
  for (const int threads : {1, 3})
    for (const Task& each : {task, reversed}) {
      arap::Options options;
      options.threads = threads;
      SurfaceArap solver(mesh.mesh(), options);
      solver.set_constraints(each.constraints);
      const Positions found = solver.solve(each.targets, to_accuracy(1e-10)).positions;
      if (expected.rows() == 0) expected = found;
      EXPECT_LT(max_distance(found, expected), 1e-8 * mesh.diagonal()) << threads;
    }
}

TEST(Patches, OfHardVerticesAloneAreRefused) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, {0, 1, 2});
  task.add_patch({20, 30}, {1, 1}, {0, 0, 3});
  task.add_patch({0, 1}, {1, 1}, {0, 0, 3});
  expect_error<arap::InvalidInput>([&] { solve_once(mesh, task, iterations(5)); },
                                   {"patch 1", "consists of hard vertices only"});
}

TEST(Patches, OverTwoPartsHoldBothTogether) {
  // What the average does not say, how the two parts move against each other, must come from somewhere: nothing runs
  // away.
  const MeshData mesh = two_spheres(1);
  Task task;
  task.add_patch({0, mesh.n_vertices() - 1}, {1, 1},
                 (mesh.vertices.front() + mesh.vertices.back()) / 2 + Vector3(0, 0, 1));
  const SolveResult result = solve_once(mesh, task, iterations(5));
  EXPECT_LT(patch_gap(task, result.positions), 1e-9);
  EXPECT_LT(max_distance(result.positions, mesh.positions()), 3);
}

}  // namespace
}  // namespace arap_test
