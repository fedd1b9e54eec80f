// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/distance_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arap {

void DistanceEstimate::add(double step, double decrease) {
  steps_[n_ % kLast] = {step, decrease};
  ++n_;
  if (n_ == 2 * kLast) n_ = kLast;  // the same place in the ring, whatever the number of steps
}

double DistanceEstimate::rate() const {
  constexpr double kUnknown = 0.9;
  constexpr double kSlowest = 0.99;
  constexpr double kFastest = 0.1;
  const int between = std::min(n_, kLast) - 1;
  if (between == 0) return kUnknown;
  const double shortened = step(0).decrease / step(between).decrease;
  // What does not become shorter has come to its rounding, or has not begun to converge; what has no length at all is
  // stuck.
  if (!(shortened > 0 && shortened < 1)) return kSlowest;
  return std::clamp(std::pow(shortened, 0.5 / between), kFastest, kSlowest);
}

double DistanceEstimate::value() const {
  // What the rate misses: it is an average over vertices; the slowest vertex converges more slowly.
  constexpr double kSafety = 3;
  if (n_ == 0) return std::numeric_limits<double>::infinity();
  const double rate = this->rate();
  double longest = 0;
  double fraction = 1;
  for (int ago = 0; ago < std::min(n_, kLast); ++ago, fraction *= rate)
    longest = std::max(longest, fraction * step(ago).length);
  return kSafety * longest * rate / (1 - rate);
}

}  // namespace arap
