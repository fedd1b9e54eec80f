// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace arap {

/// Control points of a quadratic B-spline that a cube has: three along each axis, the middle one at its centre. Control
/// point (x, y, z) is number 9 x + 3 y + z.
inline constexpr int kControlPoints = 27;

/// Weights of the three along an axis at t in [0, 1]: sum 1, positions are met (sum of (k - 1/2) w_k = t), C1 from cube
/// to cube.
[[nodiscard]] inline std::array<double, 3> spline_weights(double t) {
  return {0.5 * (1 - t) * (1 - t), 0.5 + t - t * t, 0.5 * t * t};
}

}  // namespace arap
