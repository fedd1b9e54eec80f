// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/block_ldlt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "arap/error.h"
#include "base/eigen_compat.h"
#include "base/permutation.h"
#include "cholesky/preconditioned_cg.h"
#include "cholesky/solver_choice.h"
#include "parallel/meter.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::BlockLdlt;
using arap::Isa;
using arap::SolverError;
using arap::SparseMatrix;
using arap::TileFormat;
using arap::Workers;
using Triplets = std::vector<Eigen::Triplet<double>>;

struct NamedMatrix {
  std::string name;
  SparseMatrix A;
};

/// A symmetric matrix with random values at the given couplings and a diagonal that makes it positive definite.
SparseMatrix dominant(int n, const std::vector<std::array<int, 2>>& couplings, Random& random, double margin = 1e-2) {
  Triplets entries;
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(n, margin);
  for (const auto& [i, j] : couplings) {
    if (i == j) continue;
    const double value = random.uniform(-1, 1);
    entries.emplace_back(i, j, value);
    entries.emplace_back(j, i, value);
    diagonal[i] += std::abs(value);
    diagonal[j] += std::abs(value);
  }
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, diagonal[i]);
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

SparseMatrix random_sparse(int n, double per_row, Random& random) {
  std::vector<std::array<int, 2>> couplings;
  for (int k = 0; k < per_row * n; ++k)
    couplings.push_back({static_cast<int>(random.uniform(0, n)), static_cast<int>(random.uniform(0, n))});
  return dominant(n, couplings, random);
}

/// n unknowns, `n_dense` of them coupled with all others.
SparseMatrix arrowhead(int n, int n_dense, Random& random) {
  std::vector<std::array<int, 2>> couplings;
  for (int d = 0; d < n_dense; ++d)
    for (int i = d + 1; i < n; ++i) couplings.push_back({d, i});
  return dominant(n, couplings, random);
}

SparseMatrix laplacian(const MeshData& mesh, double shift) {
  SparseMatrix K = Reference(mesh, arap::Energy::kSpokesAndRims, arap::EdgeWeights::kCotangent).matrix().sparseView();
  for (int v = 0; v < K.rows(); ++v) K.coeffRef(v, v) += shift * K.coeff(v, v);
  return K;
}

/// n * n unknowns, each coupled with the 8 around it.
SparseMatrix grid_matrix(int n, Random& random) {
  std::vector<std::array<int, 2>> couplings;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      for (const auto& [dx, dy] : {std::array{1, 0}, std::array{0, 1}, std::array{1, 1}, std::array{-1, 1}})
        if (x + dx >= 0 && x + dx < n && y + dy < n) couplings.push_back({y * n + x, (y + dy) * n + x + dx});
  return dominant(n * n, couplings, random);
}

std::vector<NamedMatrix> matrices() {
  Random random(81);
  std::vector<NamedMatrix> result;
  for (const int n : {1, 2, 3, 5, 30, 33, 100}) result.push_back({"dense", random_sparse(n, n, random)});
  for (const int n : {10, 100, 400}) result.push_back({"random sparse", random_sparse(n, 1.5, random)});
  result.push_back({"disconnected", random_sparse(300, .4, random)});
  result.push_back({"diagonal", dominant(50, {}, random)});
  result.push_back({"arrowhead", arrowhead(500, 1, random)});
  result.push_back({"three dense rows", arrowhead(300, 3, random)});
  result.push_back({"grid", grid_matrix(40, random)});
  const SparseMatrix K = laplacian(bumpy_sphere(2), 1e-2);
  result.push_back({"mesh", K});
  result.push_back({"two rings", SparseMatrix(K * K)});
  result.push_back({"two meshes", laplacian(two_spheres(2), 1e-3)});
  return result;
}

std::vector<char> erase_some(Eigen::Index n, double fraction, Random& random) {
  std::vector<char> is_erased(static_cast<size_t>(n), 0);
  for (char& e : is_erased) e = random.uniform(0, 1) < fraction ? 1 : 0;
  return is_erased;
}

/// A^-1 b without the erased rows, by Eigen and in double.
Positions solution_in_double(const SparseMatrix& A, const std::vector<char>& is_erased, const Positions& b) {
  Positions x = b;
  arap::make_linear_solver(A, Workers(1), TileFormat::kHalf, {}, exact_solver())->factorize(A, is_erased)->solve(x);
  return x;
}

/// Expects that erased rows are 0 and the others right to `tolerance`.
void expect_solution(const arap::Factorization& factor, const SparseMatrix& A, const std::vector<char>& is_erased,
                     double tolerance, const std::string& what) {
  const Positions b = Random(82).noise(static_cast<int>(A.rows()), 1);
  Positions x = b;
  factor.solve(x);
  const Positions expected = solution_in_double(A, is_erased, b);
  EXPECT_LE((x - expected).norm(), tolerance * expected.norm()) << what;
  for (size_t i = 0; i < is_erased.size(); ++i) {
    if (is_erased[i] == 0) continue;
    EXPECT_EQ(x.row(static_cast<Eigen::Index>(i)).norm(), 0) << what << ", row " << i;
  }
}

/// Instruction set and format of the tiles.
class BlockLdltOnIsa : public testing::TestWithParam<std::tuple<Isa, TileFormat>> {
 protected:
  [[nodiscard]] static BlockLdlt solver_for(const SparseMatrix& A, int threads) {
    return BlockLdlt(A, Workers(threads), std::get<0>(GetParam()), std::get<1>(GetParam()));
  }

  /// Relative error of a solve with these matrices.
  [[nodiscard]] static double tolerance() { return std::get<1>(GetParam()) == TileFormat::kHalf ? 1e-3 : 2e-5; }
};

TEST_P(BlockLdltOnIsa, AgreesWithEigenInDoubleWhicheverRowsAreErased) {
  Random random(83);
  for (const auto& [name, A] : matrices()) {
    for (const int threads : {1, 2, 3, 4}) {
      const BlockLdlt solver = solver_for(A, threads);
      for (const double fraction : {0.0, .1, .6, 1.0}) {
        const std::vector<char> is_erased = erase_some(A.rows(), fraction, random);
        const auto factor = solver.factorize(A, is_erased);
        expect_solution(*factor, A, is_erased, tolerance(),
                        name + ", " + std::to_string(A.rows()) + " rows, " + std::to_string(threads) + " threads");
        if (fraction != .6) continue;
        // The same as of a solver that has done nothing else.
        Positions x = Random(84).noise(static_cast<int>(A.rows()), 1);
        Positions y = x;
        factor->solve(x);
        solver_for(A, threads).factorize(A, is_erased)->solve(y);
        EXPECT_EQ(x, y) << name;
      }
    }
  }
}

TEST_P(BlockLdltOnIsa, ScaleOfMatrixAndRightHandSideDoesNotMatter) {
  Random random(86);
  const SparseMatrix A = grid_matrix(12, random);
  const std::vector<char> nothing(static_cast<size_t>(A.rows()), 0);
  const Positions b = random.noise(static_cast<int>(A.rows()), 1);
  const BlockLdlt solver = solver_for(A, 2);
  Positions expected = b;
  solver.factorize(A, nothing)->solve(expected);
  // Powers of two, far outside of the range of a float: the same digits.
  for (const int e_matrix : {-200, 0, 200}) {
    for (const int e_side : {-300, 0, 300}) {
      Positions x = std::exp2(e_side) * b;
      solver.factorize(std::exp2(e_matrix) * A, nothing)->solve(x);
      EXPECT_EQ(std::exp2(e_matrix - e_side) * x, expected) << e_matrix << ", " << e_side;
    }
  }
}

TEST_P(BlockLdltOnIsa, RefusesWhatIsNotPositiveDefinite) {
  Random random(88);
  for (const int threads : {1, 3}) {
    for (SparseMatrix A : {grid_matrix(30, random), random_sparse(200, 200, random)}) {
      const std::vector<char> nothing(static_cast<size_t>(A.rows()), 0);
      const BlockLdlt solver = solver_for(A, threads);
      const double diagonal = A.coeff(7, 7);
      for (const double wrong : {-1.0, 0.0}) {
        A.coeffRef(7, 7) = wrong;
        expect_error<SolverError>([&] { static_cast<void>(solver.factorize(A, nothing)); },
                                  {"positive definite", "stiffness"});
      }
      for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        A.coeffRef(7, 7) = wrong;
        expect_error<SolverError>([&] { static_cast<void>(solver.factorize(A, nothing)); }, {"(7, 7)", "not finite"});
      }
      std::vector<char> is_erased = nothing;
      is_erased[7] = 1;
      EXPECT_NO_THROW(static_cast<void>(solver.factorize(A, is_erased))) << "what is wrong is erased";
      A.coeffRef(7, 7) = diagonal;
      EXPECT_NO_THROW(static_cast<void>(solver.factorize(A, nothing)));
    }
  }
}

TEST_P(BlockLdltOnIsa, RenumberedToItsOrderingItDoesTheSame) {
  Random random(93);
  for (const auto& [name, A] : matrices()) {
    const auto n = static_cast<int>(A.rows());
    BlockLdlt solver = solver_for(A, 2);
    if (solver.ordering() == nullptr) continue;  // by chance: small ones
    const std::vector<int> order = *solver.ordering();
    const std::vector<char> is_erased = erase_some(n, .2, random);
    const auto before = solver.factorize(A, is_erased);
    const Positions b = random.noise(n, 1);

    const SparseMatrix B = arap::renumbered(A, order, arap::inverse_permutation(order), 1);
    std::vector<char> is_erased_now;
    for (const int i : order) is_erased_now.push_back(is_erased[i]);
    solver.renumber(B);
    EXPECT_EQ(solver.ordering(), nullptr);
    Positions x = b;
    before->solve(x);
    Positions y = b(order, arap::all);
    solver.factorize(B, is_erased_now)->solve(y);
    EXPECT_EQ(y, Positions(x(order, arap::all))) << name;
  }
}

TEST_P(BlockLdltOnIsa, RefusesWhatNothingHolds) {
  // Singular but for rounding: two closed meshes.
  const SparseMatrix A = laplacian(two_spheres(3), 0);
  std::vector<char> is_erased(static_cast<size_t>(A.rows()), 0);
  for (const int threads : {1, 2}) {
    const BlockLdlt solver = solver_for(A, threads);
    is_erased.front() = is_erased.back() = 0;
    const auto factorize = [&] { static_cast<void>(solver.factorize(A, is_erased)); };
    expect_error<SolverError>(factorize, {"positive definite", "stiffness"});
    is_erased.front() = 1;
    expect_error<SolverError>(factorize, {"positive definite", "stiffness"});
    is_erased.back() = 1;
    EXPECT_NO_THROW(factorize());
  }
}

INSTANTIATE_TEST_SUITE_P(All, BlockLdltOnIsa,
                         testing::Combine(testing::ValuesIn(arap::available_isas()),
                                          testing::Values(TileFormat::kFloat, TileFormat::kHalf)),
                         [](const auto& test) {
                           return std::string(arap::name(std::get<0>(test.param))) +
                                  (std::get<1>(test.param) == TileFormat::kHalf ? "_half" : "_float");
                         });

/// A chain of n unknowns that only `margin` on the diagonal of the first one holds.
SparseMatrix chain(int n, double margin) {
  Triplets entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, (i == 0 ? margin : 1.0) + (i + 1 < n ? 1.0 : 0.0));
    if (i > 0) entries.emplace_back(i, i - 1, -1);
    if (i > 0) entries.emplace_back(i - 1, i, -1);
  }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

// The solution for a force on everything is large, and rounding of the factor must not make it small: floats must
// replace halves that are too coarse.
TEST(BlockLdlt, WeaklyHeldIsNotHeldByRounding) {
  constexpr int kN = 2000;
  for (const double margin : {1e-2, 1e-4, 1e-6, 1e-10}) {
    const SparseMatrix A = chain(kN, margin);
    Positions x = Positions::Ones(kN, 3);
    BlockLdlt(A, Workers(2)).factorize(A, std::vector<char>(kN, 0))->solve(x);
    // The first unknown carries the force on all; each step along the chain, that on all behind it.
    Positions expected = Positions::Constant(kN, 3, kN / margin);
    for (int i = 1; i < kN; ++i) expected.row(i) = expected.row(i - 1).array() + (kN - i);
    EXPECT_LE((x - expected).norm(), 0.1 * expected.norm()) << margin;
  }
}

// Diagonals of very different size: halves end at 65504.
TEST(BlockLdlt, AFactorThatIsRepeatedInSinglePrecisionTakesItsPartOfTheProgressOnce) {
  constexpr int kN = 2000;
  constexpr double kPart = 0.4;
  double told = 0;
  const arap::Progress progress = [&](double fraction) {
    told = fraction;
    return true;
  };
  for (const double margin : {1.0, 1e-10}) {  // halves cannot tell that the second is held
    const SparseMatrix A = chain(kN, margin);
    const BlockLdlt solver(A, Workers(1), arap::choose_isa(), TileFormat::kHalf);
    arap::Meter meter(progress, "");
    static_cast<void>(solver.factorize(A, std::vector<char>(kN, 0), {&meter, kPart}));
    meter.tell();
    EXPECT_NEAR(told, kPart, 1e-9) << margin;
  }
}

TEST(BlockLdlt, UnknownsMayHaveVeryDifferentScales) {
  Random random(95);
  SparseMatrix A = grid_matrix(20, random);
  Eigen::VectorXd scale(A.rows());
  for (double& s : scale) s = std::pow(10, random.uniform(-12, 12));
  A = SparseMatrix(scale.asDiagonal() * A * scale.asDiagonal());
  const std::vector<char> nothing(static_cast<size_t>(A.rows()), 0);
  const auto factor = BlockLdlt(A, Workers(2)).factorize(A, nothing);
  const Positions unscaled = random.noise(static_cast<int>(A.rows()), 1);
  Positions x = scale.asDiagonal() * unscaled;
  factor->solve(x);
  const Positions product = scale.cwiseInverse().asDiagonal() * Positions(A * x);
  EXPECT_LE((product - unscaled).norm(), 2e-2 * unscaled.norm());
}

TEST(BlockLdlt, DigitsDoNotDependOnWhichThreadsTakePart) {
  Random random(96);
  const SparseMatrix A = grid_matrix(40, random);
  const auto factor = BlockLdlt(A, Workers(3)).factorize(A, std::vector<char>(static_cast<size_t>(A.rows()), 0));
  const Positions b = random.noise(static_cast<int>(A.rows()), 1);
  Positions first = b;
  factor->solve(first);
  for (int k = 0; k < 40; ++k) {  // alone and in teams
    Positions x = b;
    factor->solve(x);
    ASSERT_EQ(x, first) << k;
  }
}

TEST(BlockLdlt, RefusesARenumberedMatrixOfAnotherPattern) {
  Random random(94);
  const SparseMatrix A = random_sparse(50, 2, random);
  BlockLdlt solver(A, Workers(1));
  ASSERT_NE(solver.ordering(), nullptr);
  expect_error<SolverError>([&] { solver.renumber(A); }, {"pattern"});
  EXPECT_NE(solver.ordering(), nullptr);
  EXPECT_NO_THROW(static_cast<void>(solver.factorize(A, std::vector<char>(50, 0)))) << "nothing has changed";
  const std::vector<int> order = *solver.ordering();
  const SparseMatrix B = arap::renumbered(A, order, arap::inverse_permutation(order), 1);
  solver.renumber(B);
  expect_error<SolverError>([&] { static_cast<void>(solver.factorize(A, std::vector<char>(50, 0))); }, {"pattern"});
  EXPECT_NO_THROW(static_cast<void>(solver.factorize(B, std::vector<char>(50, 0))));
}

TEST(BlockLdlt, NoUnknowns) {
  const SparseMatrix A(0, 0);
  Positions x(0, 3);
  BlockLdlt(A, Workers(2)).factorize(A, {})->solve(x);
  EXPECT_EQ(x.rows(), 0);
}

TEST(BlockLdlt, RightHandSideThatIsNotFiniteGivesNothingFinite) {
  Random random(90);
  const SparseMatrix A = random_sparse(50, 2, random);
  Positions b = Positions::Ones(50, 3);
  b(20, 1) = std::numeric_limits<double>::infinity();
  BlockLdlt(A, Workers(1)).factorize(A, std::vector<char>(50, 0))->solve(b);
  EXPECT_TRUE(b.array().isNaN().all());
}

/// Of a few entries each, none in erased rows; some have none at all, and their numbers have very different sizes.
SparseMatrix some_columns(int n, int n_columns, const std::vector<char>& is_erased, Random& random) {
  Triplets entries;
  for (int c = 0; c < n_columns; ++c) {
    const double size = std::pow(10, random.uniform(-6, 6));
    for (int k = 0; k < c % 5; ++k)
      if (const int i = static_cast<int>(random.uniform(0, n)); is_erased[static_cast<size_t>(i)] == 0)
        entries.emplace_back(i, c, size * random.uniform(-1, 1));
  }
  SparseMatrix columns(n, n_columns);
  columns.setFromTriplets(entries.begin(), entries.end());
  return columns;
}

TEST(BlockLdlt, ABorderSolvesAsTheFactorDoes) {
  Random random(93);
  for (const auto& [name, A] : matrices())
    for (const int threads : {1, 3})
      for (const int n_columns : {1, 3, 17}) {
        const auto n = static_cast<int>(A.rows());
        const std::vector<char> is_erased = erase_some(n, .1, random);
        const auto factor = BlockLdlt(A, Workers(threads)).factorize(A, is_erased);
        const SparseMatrix columns = some_columns(n, n_columns, is_erased, random);
        const auto border = factor->border(columns);
        const Eigen::MatrixXd products = border->products();
        Positions b = random.noise(n, 1);
        for (int i = 0; i < n; ++i)
          if (is_erased[static_cast<size_t>(i)] != 0) b.row(i).setZero();
        Eigen::MatrixX3d y = Eigen::MatrixX3d::Zero(n_columns, 3);
        double parts = 0;  // of the solution, which may cancel each other
        for (int c = 0; c < n_columns; ++c) {
          Positions of_column = Positions::Zero(n, 3);
          of_column.col(0) = columns.col(c);
          const double size = columns.col(c).norm();
          if (size > 0) y.row(c) = Eigen::RowVector3d(1, -2, .5) / size;
          factor->solve(of_column);
          parts += of_column.norm() * y.row(c).norm();
          for (int other = 0; other < n_columns; ++other) {
            const double scale = std::sqrt(std::abs(products(c, c) * products(other, other)));
            EXPECT_NEAR(columns.col(other).dot(of_column.col(0)), products(other, c), 1e-5 * scale) << name;
          }
        }
        for (const double scale : {0.0, 1e-30, 1.0, 1e60}) {
          Positions x = scale * b;
          Positions expected = scale * b;
          factor->solve(expected);
          const double of_b_size = expected.norm();
          const Eigen::MatrixX3d of_b = columns.transpose() * expected;
          const Eigen::MatrixX3d chosen = (scale == 0 ? 1 : scale) * y;
          expected = scale * b - columns * chosen;
          factor->solve(expected);
          border->solve(
              [&, &name = name](const Eigen::MatrixX3d& found) {
                for (int c = 0; c < n_columns; ++c)
                  EXPECT_LE((found.row(c) - of_b.row(c)).norm(),
                            1e-4 * scale * b.norm() * std::sqrt(products(c, c)) * (1 + std::sqrt(expected.norm())))
                      << name;
                return chosen;
              },
              x);
          EXPECT_LE((x - expected).norm(), 1e-5 * (expected.norm() + of_b_size + (scale == 0 ? 1 : scale) * parts))
              << name << ", " << scale;
        }
      }
}

TEST(SolveWithCg, IsExactEvenForBadConditions) {
  for (const double shift : {1e-2, 1e-4, 1e-6}) {
    const SparseMatrix K = laplacian(bumpy_sphere(2), shift);
    for (const SparseMatrix& A : {K, SparseMatrix(K * K)}) {
      const std::vector<char> nothing(static_cast<size_t>(A.rows()), 0);
      const auto factor = BlockLdlt(A, Workers(2)).factorize(A, nothing);
      Positions x = Random(91).noise(static_cast<int>(A.rows()), 1);
      const Positions b = x;
      arap::solve_with_cg([&](const Positions& p, Positions& q) { q = A * p; },
                          [&](const Positions& p, Positions& q) { factor->solve(p, q); }, x, Workers(2));
      // As good as a dense factorization in double: the residual is rounding of A x.
      EXPECT_LE((A * x - b).norm(), 1e-13 * A.norm() * x.norm()) << shift;
    }
  }
}

TEST(SolveWithCg, ZeroStaysZero) {
  Random random(92);
  const SparseMatrix A = random_sparse(50, 2, random);
  Positions x = Positions::Zero(50, 3);
  x(3, 1) = 1;  // one side of three
  const auto factor = BlockLdlt(A, Workers(1)).factorize(A, std::vector<char>(50, 0));
  arap::solve_with_cg([&](const Positions& p, Positions& q) { q = A * p; },
                      [&](const Positions& p, Positions& q) { factor->solve(p, q); }, x, Workers(2));
  EXPECT_EQ(x.col(0).norm(), 0);
  EXPECT_EQ(x.col(2).norm(), 0);
  EXPECT_TRUE(x.allFinite());
}

}  // namespace
}  // namespace arap_test
