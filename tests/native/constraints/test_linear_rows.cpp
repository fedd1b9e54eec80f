// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/linear_rows.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::LinearRows;
using arap::RowMatrix;

TEST(LinearRows, MultiplyAsADenseMatrix) {
  LinearRows rows;
  rows.add({{1, 4, 1}, {2, -1, .5}}, 3);
  rows.add({{0}, {7}}, 1);
  rows.add({{5, 2}, {1, 1}}, .5);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3, 6);
  dense.row(0) << 0, 2.5, 0, 0, -1, 0;
  dense(1, 0) = 7;
  dense(2, 5) = dense(2, 2) = 1;
  const RowMatrix matrix(rows, 6);
  const Positions x = Random(1).noise(6, 1);
  const arap::Workers workers(2);
  Positions y;
  matrix.multiply(x, y, workers);
  EXPECT_LT(max_distance(y, dense * x), 1e-15);
  Positions sum = x;
  matrix.add_transposed(y, sum, workers);
  EXPECT_LT(max_distance(sum, x + dense.transpose() * y), 1e-14);
  const Eigen::Vector3d weights(3, 1, .5);
  EXPECT_LT((Eigen::MatrixXd(matrix.normal_matrix(weights)) - dense.transpose() * weights.asDiagonal() * dense).norm(),
            1e-14);
  EXPECT_LT((rows.rows[0].of(x) - dense.row(0) * x).norm(), 1e-15);
}

TEST(LinearRows, SayWhatIsWrong) {
  const auto expect_refused = [](const arap::LinearRow& row, double weight,
                                 std::initializer_list<std::string_view> words) {
    LinearRows rows;
    rows.add({{0}, {1}}, 1);
    rows.add(row, weight);
    expect_error<arap::InvalidInput>([&] { rows.validate(5); }, words);
  };
  expect_refused({{1, 5}, {1, 1}}, 1, {"row 1", "unknown 5", "0 to 4"});
  expect_refused({{1, -1}, {1, 1}}, 1, {"row 1", "unknown -1"});
  expect_refused({{1, 2}, {1, std::numeric_limits<double>::quiet_NaN()}}, 1, {"row 1", "unknown 2", "not finite"});
  expect_refused({{1, 2}, {0, 0}}, 1, {"row 1", "no coefficient"});
  expect_refused({{}, {}}, 1, {"row 1", "no coefficient"});
  for (const double weight : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    expect_refused({{1}, {1}}, weight, {"weight of row 1", "above 0"});
  LinearRows rows;
  rows.add({{4}, {1}}, LinearRows::kHard);
  EXPECT_NO_THROW(rows.validate(5));
}

}  // namespace
}  // namespace arap_test
