// SPDX-License-Identifier: GPL-3.0-or-later
#include "bumpy_torus.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

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

PolygonMesh BumpyTorus::mesh() const {
  std::vector<int> corner_vertices;
  for (int i = 0; i < n_around; ++i) {
    for (int j = 0; j < n_across; ++j) {
      const int next_i = (i + 1) % n_around;
      const int next_j = (j + 1) % n_across;
      corner_vertices.insert(corner_vertices.end(), {i * n_across + j, next_i * n_across + j,
                                                     next_i * n_across + next_j, i * n_across + next_j});
    }
  }
  return {positions, corner_vertices, std::vector<int>(static_cast<size_t>(n_around) * n_across, 4)};
}

std::vector<int> BumpyTorus::rings(int first, int n_rings) const {
  std::vector<int> vertices(static_cast<size_t>(n_rings) * n_across);
  std::iota(vertices.begin(), vertices.end(), first * n_across);
  return vertices;
}

}  // namespace arap::bench
