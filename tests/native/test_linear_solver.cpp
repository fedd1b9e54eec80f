// SPDX-License-Identifier: GPL-3.0-or-later
#include "linear_solver.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>
#include <vector>

#include "arap/error.h"
#include "helpers.h"

namespace arap_test {
namespace {

using arap::SolverError;
using arap::SparseMatrix;

SparseMatrix laplacian(const MeshData& mesh) {
  return Reference(mesh, arap::Energy::kSpokesAndRims, arap::EdgeWeights::kCotangent).matrix().sparseView();
}

std::vector<char> erase(Eigen::Index n, const std::vector<int>& vertices) {
  std::vector<char> is_erased(static_cast<size_t>(n), 0);
  for (const int v : vertices) is_erased[v] = 1;
  return is_erased;
}

TEST(LinearSolver, SolvesWithErasedRowsAndColumns) {
  for (const MeshData& mesh : {bumpy_sphere(2), star_prism(5, 4), book(4, Faces::kTriangles)}) {
    const SparseMatrix A = laplacian(mesh);
    const std::vector<int> erased = {0, 3, mesh.n_vertices() - 1};
    const auto factor =
        arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1)->factorize(A, erase(A.rows(), erased));
    const Positions b = Random(61).noise(mesh.n_vertices(), 1);
    Positions x = b;
    factor->solve(x);
    Positions residual = A * x - b;
    for (const int v : erased) {
      EXPECT_EQ(x.row(v).norm(), 0);
      residual.row(v).setZero();
    }
    EXPECT_LT(residual.norm(), 1e-11 * b.norm()) << mesh.name;
  }
}

TEST(LinearSolver, NothingErased) {
  SparseMatrix A = laplacian(bumpy_sphere(1));
  for (int v = 0; v < A.rows(); ++v) A.coeffRef(v, v) += 1;
  const auto factor =
      arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1)->factorize(A, erase(A.rows(), {}));
  const Positions b = Random(62).noise(static_cast<int>(A.rows()), 1);
  Positions x = b;
  factor->solve(x);
  EXPECT_LT((A * x - b).norm(), 1e-12 * b.norm());
}

TEST(LinearSolver, EverythingErased) {
  const SparseMatrix A = laplacian(cube());
  const auto factor =
      arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1)->factorize(A, std::vector<char>(8, 1));
  Positions x = Positions::Ones(8, 3);
  factor->solve(x);
  EXPECT_EQ(x, Positions::Zero(8, 3));
}

TEST(LinearSolver, OneServesManyValuesAndSetsOfErasedRows) {
  const SparseMatrix A = laplacian(bumpy_sphere(1));
  const auto solver = arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1);
  const auto first = solver->factorize(A, erase(A.rows(), {0}));
  const auto second = solver->factorize(2 * A, erase(A.rows(), {5, 6}));
  const Positions b = Random(63).noise(static_cast<int>(A.rows()), 1);
  Positions x = b;
  second->solve(x);
  Positions y = b;
  arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1)
      ->factorize(2 * A, erase(A.rows(), {5, 6}))
      ->solve(y);
  EXPECT_EQ(x, y);
  first->solve(x = b);
  Positions residual = A * x - b;
  residual.row(0).setZero();
  EXPECT_LT(residual.norm(), 1e-11 * b.norm()) << "the first factor is not touched by the second";
}

TEST(LinearSolver, EveryKindIsAsGoodInItsOwnOrder) {
  const SparseMatrix A = laplacian(bumpy_sphere(2));
  for (const auto kind : {arap::LinearSolverKind::kSimplicialLdlt, arap::LinearSolverKind::kBlockLdlt}) {
    const auto solver = arap::make_linear_solver(A, kind, 2);
    SparseMatrix B = A;
    if (const std::vector<int>* order = solver->order()) {
      Eigen::PermutationMatrix<Eigen::Dynamic> to_new(A.rows());
      for (Eigen::Index k = 0; k < A.rows(); ++k) to_new.indices()[(*order)[k]] = static_cast<int>(k);
      B = A.twistedBy(to_new);
      solver->renumber(B);
    }
    EXPECT_EQ(solver->order(), nullptr);
    const Positions b = Random(66).noise(static_cast<int>(A.rows()), 1);
    Positions x = b;
    solver->factorize(B, erase(A.rows(), {0}))->solve(x);
    Positions residual = B * x - b;
    residual.row(0).setZero();
    EXPECT_LT(residual.norm(), 2e-2 * b.norm());
  }
}

TEST(LinearSolver, IndefiniteMatrixIsRefused) {
  const SparseMatrix A = -1 * laplacian(bumpy_sphere(1));
  const auto solver = arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1);
  EXPECT_THROW(static_cast<void>(solver->factorize(A, erase(A.rows(), {0}))), SolverError);
}

TEST(LinearSolver, MatrixThatIsNotFiniteIsRefused) {
  SparseMatrix A = laplacian(bumpy_sphere(1));
  A.coeffRef(3, 3) = std::numeric_limits<double>::quiet_NaN();
  const auto solver = arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1);
  EXPECT_THROW(static_cast<void>(solver->factorize(A, erase(A.rows(), {0}))), SolverError);
}

TEST(LinearSolver, SolvesFromSeveralThreads) {
  const SparseMatrix A = laplacian(bumpy_sphere(3));
  const auto factor =
      arap::make_linear_solver(A, arap::LinearSolverKind::kSimplicialLdlt, 1)->factorize(A, erase(A.rows(), {0}));
  const Positions b = Random(64).noise(static_cast<int>(A.rows()), 1);
  Positions expected = b;
  factor->solve(expected);
  std::vector<Positions> results(4, b);
  std::vector<std::thread> threads;
  for (Positions& x : results) threads.emplace_back([&factor, &x] { factor->solve(x); });
  for (std::thread& thread : threads) thread.join();
  for (const Positions& x : results) EXPECT_EQ(x, expected);
}

TEST(Multiply, IsTheProductWithAnyNumberOfThreads) {
  const SparseMatrix A = laplacian(bumpy_sphere(3));
  const Positions x = Random(65).noise(static_cast<int>(A.rows()), 1);
  const Positions expected = A * x;
  for (const int threads : {1, 2}) {
    Positions result;
    arap::multiply(A, x, result, threads);
    EXPECT_LT((result - expected).norm(), 1e-13 * expected.norm());
  }
}

}  // namespace
}  // namespace arap_test
