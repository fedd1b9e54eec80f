// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "support/meshes.h"

namespace arap_test {
namespace {

TEST(PointTree, FindsTheNearestOnes) {
  Random random(3);
  Positions points(400, 3);
  for (int k = 0; k < 400; ++k) points.row(k) = random.vector(1).transpose();
  for (int k = 0; k < 40; ++k) points.row(360 + k) = points.row(k);  // equally near: the lowest first
  const arap::PointTree tree(points);
  std::vector<arap::PointTree::Near> found;
  for (int query = 0; query < 200; ++query) {
    Eigen::RowVector3d place = random.vector(query < 100 ? 1 : 5).transpose();
    if (query < 20) place = points.row(query);
    std::vector<std::pair<double, int>> expected;
    for (int k = 0; k < 400; ++k) expected.emplace_back((points.row(k) - place).squaredNorm(), k);
    std::sort(expected.begin(), expected.end());
    tree.nearest(place, 5, found);
    ASSERT_EQ(found.size(), 5U);
    for (size_t k = 0; k < 5; ++k) EXPECT_EQ(found[k].point, expected[k].second);
    tree.nearest(place, 5, found, 1.5);
    for (size_t k = 0; k < 5; ++k) EXPECT_LE(found[k].squared, 1.5 * 1.5 * expected[k].first);
  }
}

TEST(PointTree, FindsAllWhereThereAreFewer) {
  std::vector<arap::PointTree::Near> found;
  const Positions points = Positions::Zero(2, 3);
  arap::PointTree(points).nearest(Eigen::RowVector3d(1, 0, 0), 5, found);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].point, 0);
  EXPECT_EQ(found[1].squared, 1);
}

}  // namespace
}  // namespace arap_test
