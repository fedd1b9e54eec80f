// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_weights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Cage;
using arap::CageCoordinates;

/// Expects that the weights in single precision, of every instruction set, are those in double.
void expect_rounded(const MeshData& mesh, CageCoordinates coordinates, Positions points) {
  const Cage cage(mesh.mesh());
  for (auto point : points.rowwise()) point = cage.to_cage(point);
  const auto n = static_cast<int>(points.rows());
  for (const arap::Isa isa : arap::available_isas()) {
    arap::WeightBlocks weights(n, n_weight_rows(cage, coordinates));
    EXPECT_TRUE(compute_weights(cage, coordinates, points, 1, {}, weights, isa).empty());
    double off = 0;
    for (int p = 0; p < n; ++p) {
      const arap::CageWeights expected = weights_of(cage, coordinates, points.row(p));
      Eigen::VectorXd rows(weights.n_rows());
      rows << expected.vertices, expected.triangles / cage.size();
      for (int row = 0; row < weights.n_rows(); ++row) {
        const auto weight = static_cast<double>(weights.block(p / 16)[16 * row + p % 16]);
        off = std::max(off, std::abs(weight - rows[row]) / (1e-3 + std::abs(rows[row])));
      }
    }
    EXPECT_LT(off, 6e-8) << mesh.name << ", " << name(isa);
  }
}

TEST(CageWeights, EveryInstructionSetHasTheMeanValues) {
  for (const MeshData& mesh : all_cages()) {
    Positions points(45, 3);  // the last block is not full; many are outside, some on the cage
    points << points_inside(mesh, 20), Random(3).noise(20, mesh.diagonal()), mesh.positions().topRows(4),
        mesh.positions().row(0) * (1 - 1e-7);
    expect_rounded(mesh, CageCoordinates::kMeanValue, points);
  }
}

TEST(CageWeights, EveryInstructionSetHasGreensCoordinates) {
  for (const MeshData& mesh : all_cages()) expect_rounded(mesh, CageCoordinates::kGreen, points_inside(mesh, 45));
  expect_rounded(cube(), CageCoordinates::kGreen, .999999 * cube().positions());
}

TEST(CageWeights, GreenTellsWhatIsNotInside) {
  const Cage cage(cube().mesh());
  Positions points(20, 3);
  points << points_inside(cube(), 9), .6, 0, 0, 0, .5, 0, points_inside(cube(), 9);
  for (auto point : points.rowwise()) point = cage.to_cage(point);
  for (const arap::Isa isa : arap::available_isas()) {
    arap::WeightBlocks weights(20, n_weight_rows(cage, CageCoordinates::kGreen));
    EXPECT_EQ(compute_weights(cage, CageCoordinates::kGreen, points, 1, {}, weights, isa), (std::vector{9, 10}));
  }
}

}  // namespace
}  // namespace arap_test
