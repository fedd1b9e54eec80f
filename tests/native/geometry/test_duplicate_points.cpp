// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/duplicate_points.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/meshes.h"

namespace arap_test {
namespace {

TEST(CoincidentWith, NamesTheLowestVertexAtTheSamePlace) {
  const Positions p{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 1e-12}, {0, 0, 0}, {1, 0, 1}};
  EXPECT_EQ(arap::coincident_with(p, 1e-9, 2), (std::vector<int>{0, 1, 0, 1, 0, 5}));
}

TEST(CoincidentWith, DistanceZeroJoinsOnlyEqualPlaces) {
  const Positions p{{0, 0, 0}, {0, 0, 1e-300}, {0, 0, 0}, {-0.0, 0, 0}};
  EXPECT_EQ(arap::coincident_with(p, 0, 2), (std::vector<int>{0, 1, 0, 0}));
}

TEST(CoincidentWith, FindsPairsOnBothSidesOfEveryCell) {
  // Pairs a hair closer than the distance, all over a box that is large against it.
  Random random(5);
  constexpr int kPairs = 500;
  constexpr double kDistance = 1e-6;
  Positions p(2 * kPairs, 3);
  for (int k = 0; k < kPairs; ++k) {
    p.row(k) = random.vector(1).transpose();
    p.row(kPairs + k) = p.row(k) + .99 * kDistance * random.vector(1).transpose();
  }
  const std::vector<int> lowest = arap::coincident_with(p, kDistance, 2);
  for (int k = 0; k < kPairs; ++k) {
    EXPECT_EQ(lowest[k], k);
    EXPECT_EQ(lowest[kPairs + k], k);
  }
}

/// Crowded: coincidence is not transitive.
TEST(CoincidentWith, MapsEachToOneThatMapsToItselfOnAnyNumberOfThreads) {
  Random random(6);
  constexpr int kVertices = 2000;
  constexpr double kDistance = .02;
  Positions p(kVertices, 3);
  for (int v = 0; v < kVertices; ++v) p.row(v) = .2 * random.vector(1).transpose();
  const std::vector<int> lowest = arap::coincident_with(p, kDistance, 1);
  for (int v = 0; v < kVertices; ++v) {
    const auto is_near = [&](int u) { return (p.row(u) - p.row(v)).cwiseAbs().maxCoeff() <= kDistance; };
    EXPECT_LE(lowest[v], v);
    EXPECT_EQ(lowest[lowest[v]], lowest[v]);
    EXPECT_TRUE(is_near(lowest[v]));
    for (int u = 0; u < v && lowest[v] == v; ++u) EXPECT_FALSE(lowest[u] == u && is_near(u)) << u << ", " << v;
  }
  EXPECT_EQ(arap::coincident_with(p, kDistance, 3), lowest);
}

}  // namespace
}  // namespace arap_test
