// SPDX-License-Identifier: GPL-3.0-or-later
// The solver and the references do what linear_solver.h says, and all lead to the same shape.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "arap/error.h"
#include "cholesky/solver_choice.h"
#include "references/eigen_solvers.h"
#include "support/dense.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InitialGuess;
using arap::reference_solver;
using arap::ReferenceSolver;
using arap::SolverError;
using arap::SparseMatrix;

struct Kind {
  const arap::SolverFactory* factory;
  const char* name;
  double tolerance;       ///< of one solve, relative to the solution
  bool tells_indefinite;  ///< also if the diagonal is positive
};

void PrintTo(const Kind& kind, std::ostream* stream) { *stream << kind.name; }

const std::array kKinds = {
    Kind{kOwnSolver, "block_ldlt", 5e-3, true},
    Kind{exact_solver(), "simplicial_ldlt", 1e-11, true},
    Kind{&reference_solver(ReferenceSolver::kSparseLu), "sparse_lu", 1e-11, true},
    Kind{&reference_solver(ReferenceSolver::kSparseQr), "sparse_qr", 1e-11, false},
    Kind{&reference_solver(ReferenceSolver::kBiCgStab), "bicgstab", 1e-7, false},
};

/// A small matrix, row by row.
SparseMatrix matrix(int n, const std::vector<double>& entries) {
  return Eigen::Map<const Eigen::MatrixXd>(entries.data(), n, n).sparseView();
}

SparseMatrix stiffness_matrix(const MeshData& mesh) {
  return Reference(mesh, arap::Energy::kSpokesAndRims, arap::EdgeWeights::kCotangent).matrix().sparseView();
}

std::vector<char> erase(Eigen::Index n, const std::vector<int>& rows) {
  std::vector<char> is_erased(static_cast<size_t>(n), 0);
  for (const int i : rows) is_erased[i] = 1;
  return is_erased;
}

class LinearSolverKinds : public testing::TestWithParam<Kind> {
 protected:
  [[nodiscard]] std::unique_ptr<arap::Factorization> factorize(const SparseMatrix& A,
                                                               const std::vector<int>& erased) const {
    return arap::make_linear_solver(A, arap::Workers(2), arap::TileFormat::kHalf, {}, GetParam().factory)
        ->factorize(A, erase(A.rows(), erased));
  }

  void expect_refused(const SparseMatrix& A, const std::vector<int>& erased) const {
    expect_error<arap::NotPositiveDefinite>([&] { static_cast<void>(factorize(A, erased)); },
                                            {"not positive definite", "stiffness"});
  }
};

TEST_P(LinearSolverKinds, SolvesWithErasedRowsAndColumns) {
  for (const MeshData& mesh : {bumpy_sphere(3), star_prism(5, 4), book(4, Faces::kTriangles)}) {
    const SparseMatrix A = stiffness_matrix(mesh);
    const std::vector<int> erased = {0, 3, mesh.n_vertices() - 1};
    const Positions b = Random(81).noise(mesh.n_vertices(), 1);
    Eigen::MatrixXd dense = A;
    Positions expected = b;
    for (const int v : erased) {
      dense.row(v).setZero();
      dense.col(v).setZero();
      dense(v, v) = 1;
      expected.row(v).setZero();
    }
    expected = solver_of(dense)(expected);
    Positions x = b;
    factorize(A, erased)->solve(x);
    for (const int v : erased) EXPECT_EQ(x.row(v).norm(), 0);
    EXPECT_LT(max_distance(x, expected), GetParam().tolerance * expected.cwiseAbs().maxCoeff()) << mesh.name;
  }
}

TEST_P(LinearSolverKinds, ZeroGivesZeroAndTinyAndHugeNumbersTheSameAsOrdinaryOnes) {
  const SparseMatrix A = stiffness_matrix(bumpy_sphere(1));
  const auto factor = factorize(A, {0});
  const Positions b = Random(82).noise(static_cast<int>(A.rows()), 1);
  Positions zero = Positions::Zero(A.rows(), 3);
  factor->solve(zero);
  EXPECT_EQ(zero.norm(), 0);
  Positions expected = b;
  factor->solve(expected);
  for (const double scale : {1e-25, 1e25}) {
    Positions x = scale * b;
    factor->solve(x);
    EXPECT_LT(max_distance(x / scale, expected), GetParam().tolerance * expected.cwiseAbs().maxCoeff()) << scale;
  }
}

TEST_P(LinearSolverKinds, SolvesFromSeveralThreads) {
  const SparseMatrix A = stiffness_matrix(bumpy_sphere(2));
  const auto factor = factorize(A, {0});
  const Positions b = Random(83).noise(static_cast<int>(A.rows()), 1);
  Positions expected = b;
  factor->solve(expected);
  std::vector<Positions> results(4, b);
  std::vector<std::thread> threads;
  for (Positions& x : results) threads.emplace_back([&factor, &x] { factor->solve(x); });
  for (std::thread& thread : threads) thread.join();
  for (const Positions& x : results)
    EXPECT_LT(max_distance(x, expected), GetParam().tolerance * expected.cwiseAbs().maxCoeff());
}

TEST_P(LinearSolverKinds, RefusesADiagonalThatIsNotPositive) {
  expect_refused(-1 * stiffness_matrix(bumpy_sphere(1)), {0});
  expect_refused(matrix(3, {2, 0, 1, 0, 0, 0, 1, 0, 2}), {});
}

TEST_P(LinearSolverKinds, RefusesWhatIsNotFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const SparseMatrix& A : {matrix(2, {kNan, 1, 1, 2}), matrix(2, {2, kNan, kNan, 2})})
    expect_error<SolverError>([&] { static_cast<void>(factorize(A, {})); }, {"entry (", "nan", "not finite"});
}

TEST_P(LinearSolverKinds, WhatIsErasedMayBeAnything) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Positions x = Positions::Ones(3, 3);
  factorize(matrix(3, {2, kNan, 0, kNan, -1, 0, 0, 0, 4}), {1})->solve(x);
  Positions expected(3, 3);
  expected << .5, .5, .5, 0, 0, 0, .25, .25, .25;
  EXPECT_LT(max_distance(x, expected), GetParam().tolerance);
}

TEST_P(LinearSolverKinds, RefusesASingularMatrix) {
  const SparseMatrix A = matrix(3, {1, 1, 0, 1, 1, 0, 0, 0, 1});
  if (GetParam().factory != &reference_solver(ReferenceSolver::kBiCgStab)) return expect_refused(A, {});
  Positions b = Positions::Zero(3, 3);
  b.row(0).setOnes();  // not in the range of A
  expect_error<SolverError>([&] { factorize(A, {})->solve(b); }, {"BiCGSTAB did not converge", "another solver"});
}

TEST_P(LinearSolverKinds, CholeskyAndLuRefuseIndefiniteMatricesWithAPositiveDiagonal) {
  // The second one has a leading minor of 0: it has no factorization with pivots on the diagonal.
  for (const SparseMatrix& A : {matrix(2, {1, 2, 2, 1}), matrix(3, {1, 1, 0, 1, 1, 1, 0, 1, 1})}) {
    if (GetParam().tells_indefinite) {
      expect_refused(A, {});
      continue;
    }
    // QR solves the system; BiCGSTAB may fail instead.
    const Positions b = Positions::Ones(A.rows(), 3);
    Positions x = b;
    try {
      factorize(A, {})->solve(x);
      EXPECT_LT(max_distance(A * x, b), 1e-9);
    } catch (const SolverError& error) {
      EXPECT_NE(std::string(error.what()).find("BiCGSTAB did not converge"), std::string::npos) << error.what();
    }
  }
}

/// Hard and soft vertices and a patch, from every start.
TEST_P(LinearSolverKinds, SurfacesConvergeToTheSameShape) {
  const MeshData mesh = bar(3, Faces::kQuads);
  Task task = bend_task(mesh, default_bend(mesh));
  const int middle = mesh.n_vertices() / 2;
  task.constraints.strengths.front() = .5;
  task.add_patch({middle, middle + 1}, {1, 1},
                 (mesh.vertices[middle] + mesh.vertices[middle + 1]) / 2 + Vector3(0, 0, .05) * mesh.diagonal());
  arap::Options options;
  options.solver_factory = GetParam().factory;
  const arap::SolveResult expected = solve_once(mesh, task, to_accuracy(1e-9), exactly());
  for (const InitialGuess guess :
       {InitialGuess::kRest, InitialGuess::kNaiveLaplacian, InitialGuess::kHandleRotations}) {
    const arap::SolveResult result = solve_once(mesh, task, to_accuracy(1e-9, guess), options);
    EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
    EXPECT_LT(max_distance(result.positions, expected.positions), 1e-6 * mesh.diagonal());
    EXPECT_NEAR(result.energy_after, expected.energy_after, 1e-9 * expected.energy_after);
  }
}

std::string kind_name(const testing::TestParamInfo<Kind>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(All, LinearSolverKinds, testing::ValuesIn(kKinds), kind_name);

TEST(Multiply, IsTheProductWithAnyNumberOfThreads) {
  const SparseMatrix A = stiffness_matrix(bumpy_sphere(3));
  const Positions x = Random(65).noise(static_cast<int>(A.rows()), 1);
  const Positions expected = A * x;
  for (const int threads : {1, 2}) {
    Positions result;
    arap::multiply(A, x, result, arap::Workers(threads));
    EXPECT_LT((result - expected).norm(), 1e-13 * expected.norm());
  }
}

}  // namespace
}  // namespace arap_test
