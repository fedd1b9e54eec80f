// SPDX-License-Identifier: GPL-3.0-or-later
#include "bumpy_torus.h"

#include <cmath>
#include <numbers>

namespace arap::bench {

BumpyTorus::BumpyTorus(int n_vertices)
    : n_around(static_cast<int>(std::lround(std::sqrt(3.0 * n_vertices)))),
      n_across(n_vertices / n_around),
      positions(n_around * n_across, 3) {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (int i = 0; i < n_around; ++i) {
    for (int j = 0; j < n_across; ++j) {
      const double u = kTurn * i / n_around;
      const double v = kTurn * j / n_across;
      const double tube = 0.3 + 0.03 * std::sin(7 * u) * std::cos(5 * v);
      const double radius = 1 + tube * std::cos(v);
      positions.row(i * n_across + j) << radius * std::cos(u), radius * std::sin(u), tube * std::sin(v);
    }
  }
}

}  // namespace arap::bench
