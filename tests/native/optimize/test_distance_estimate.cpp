// SPDX-License-Identifier: GPL-3.0-or-later
// Of steps that become shorter at a known rate the sum of all that follow is known.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "optimize/distance_estimate.h"

namespace {

using arap::DistanceEstimate;

/// n steps that become shorter by `rate`, and `factor` times as long; the energy falls by their squares.
DistanceEstimate after(int n, double rate, double factor = 1) {
  DistanceEstimate estimate;
  for (int k = 0; k < n; ++k) {
    const double step = factor * std::pow(rate, k);
    estimate.add(step, 7 * step * step);
  }
  return estimate;
}

/// What follows n steps of `rate`.
double rest_of(int n, double rate) { return std::pow(rate, n) / (1 - rate); }

TEST(DistanceEstimate, IsInfiniteBeforeTheFirstStepAndOnceItIsForgotten) {
  EXPECT_EQ(DistanceEstimate().value(), std::numeric_limits<double>::infinity());
  DistanceEstimate estimate = after(5, .5);
  estimate.forget();
  EXPECT_EQ(estimate.value(), std::numeric_limits<double>::infinity());
}

TEST(DistanceEstimate, IsTheSumOfEvenStepsToComeWithSomeToSpare) {
  for (const double rate : {.3, .7, .95})
    for (const int n : {2, 5, 10, 11, 37}) {
      EXPECT_GE(after(n, rate).value(), 1.5 * rest_of(n, rate)) << rate << ", " << n;
      EXPECT_LE(after(n, rate).value(), 4 * rest_of(n, rate)) << rate << ", " << n;
    }
}

TEST(DistanceEstimate, GoesWithTheLengthOfTheSteps) {
  EXPECT_NEAR(after(20, .8, 1e-3).value(), 1e-3 * after(20, .8).value(), 1e-12 * after(20, .8).value());
}

TEST(DistanceEstimate, IsFarMoreThanAStepWhereStepsDoNotBecomeShorter) {
  EXPECT_GE(after(8, 1).value(), 50);
  EXPECT_GE(after(8, 1.2).value(), 50);
}

TEST(DistanceEstimate, ASingleShortStepIsNotTheEnd) {
  DistanceEstimate estimate = after(10, .9);
  const double before = estimate.value();
  estimate.add(1e-12, 7 * .9 * .9);
  EXPECT_GE(estimate.value(), .5 * before);
}

TEST(DistanceEstimate, AStepOfNoLengthIsStuckNotNear) {
  DistanceEstimate estimate = after(10, .9);
  const double before = estimate.value();
  estimate.add(0, 0);
  EXPECT_GE(estimate.value(), before);
}

TEST(DistanceEstimate, IsNothingWhereNothingMoves) {
  DistanceEstimate estimate;
  estimate.add(0, 0);
  EXPECT_EQ(estimate.value(), 0);
  estimate.add(0, 0);
  EXPECT_EQ(estimate.value(), 0);
}

}  // namespace
