// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/smallest_change.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/dense.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::LinearRow;
using arap::LinearRows;
using arap::SmallestChange;

constexpr int kUnknowns = 12;

/// Rows of four unknowns each.
LinearRows random_rows(int n, Random& random) {
  LinearRows rows;
  for (int r = 0; r < n; ++r) {
    LinearRow row;
    for (int k = 0; k < 4; ++k) {
      row.indices.push_back((5 * r + 3 * k) % kUnknowns);
      row.coefficients.push_back(random.uniform(.1, 1));
    }
    rows.add(row, random.uniform(.5, 2));
  }
  return rows;
}

Eigen::MatrixXd dense(const LinearRows& rows) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows.size(), kUnknowns);
  for (int r = 0; r < rows.size(); ++r)
    for (size_t k = 0; k < rows.rows[r].indices.size(); ++k)
      A(r, rows.rows[r].indices[k]) += rows.rows[r].coefficients[k];
  return A;
}

Positions expected_change(const LinearRows& rows, const std::vector<char>& is_fixed, const Positions& gaps) {
  Eigen::MatrixXd A = dense(rows);
  for (int i = 0; i < kUnknowns; ++i)
    if (is_fixed[i] != 0) A.col(i).setZero();
  const Eigen::VectorXd scales = rows.weight_vector().cwiseSqrt();
  return least_squares(scales.asDiagonal() * A, scales.asDiagonal() * gaps);
}

TEST(SmallestChange, IsThatOfThePseudoinverse) {
  Random random(1);
  std::vector<char> is_fixed(kUnknowns, 0);
  is_fixed[3] = 1;
  for (const int n : {1, 5, 9, 30}) {  // from some on they contradict each other
    SCOPED_TRACE(n);
    LinearRows rows = random_rows(n, random);
    rows.add(rows.rows.front(), 1);
    const Positions gaps = random.noise(rows.size(), 1);
    Positions x = random.noise(kUnknowns, 1);
    const Positions expected = x + expected_change(rows, is_fixed, gaps);
    SmallestChange(rows, is_fixed).close(gaps, x, arap::Workers(1));
    EXPECT_LT(max_distance(x, expected), 1e-10);
  }
}

TEST(SmallestChange, OfRowsThatNothingMovesIsNone) {
  Random random(2);
  const LinearRows rows = random_rows(4, random);
  const std::vector<char> is_fixed(kUnknowns, 1);
  const Positions before = random.noise(kUnknowns, 1);
  Positions x = before;
  SmallestChange(rows, is_fixed).close(random.noise(4, 1), x, arap::Workers(1));
  EXPECT_EQ(x, before);
  EXPECT_TRUE(SmallestChange().empty());
}

}  // namespace
}  // namespace arap_test
