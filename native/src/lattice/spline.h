// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace arap {

/// Weights of a quadratic B-spline's three control points along an axis at t in [0, 1], the middle one at 1/2: sum 1,
/// positions are met (sum of (k - 1/2) w_k = t), C1 from cube to cube.
[[nodiscard]] inline std::array<double, 3> spline_weights(double t) {
  return {0.5 * (1 - t) * (1 - t), 0.5 + t - t * t, 0.5 * t * t};
}

}  // namespace arap
