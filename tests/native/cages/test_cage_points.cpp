// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_points.h"

#include <gtest/gtest.h>

#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::CageCoordinates;
using arap::CagePoints;

TEST(CagePoints, RowsAreWhatADeformationDoes) {
  for (const MeshData& mesh : all_cages())
    for (const CageCoordinates coordinates : {CageCoordinates::kMeanValue, CageCoordinates::kHarmonic}) {
      arap::CageOptions options;
      options.coordinates = coordinates;
      options.grid_spacing = .05;
      const CagePoints points(mesh.mesh(), points_inside(mesh, 20), options, {});
      const Positions moved = 2 * mesh.positions() + Random(9).noise(mesh.n_vertices(), .3 * mesh.diagonal());
      Positions carried(20, 3);
      points.deform(moved, [&](int p, const Vector3& place) { carried.row(p) = place.transpose(); });
      EXPECT_LT(max_distance(points.rows(0, 20) * moved, carried), 1e-13 * mesh.diagonal()) << mesh.name;
      const std::vector<int> two{3, 7};
      EXPECT_LT((points.rows(two).row(1) - points.rows(5, 4).row(2)).norm(), 1e-15);
      EXPECT_LT((points.transposed(two, carried.topRows(2)) - points.rows(two).transpose() * carried.topRows(2)).norm(),
                1e-13 * mesh.diagonal());
    }
}

}  // namespace
}  // namespace arap_test
