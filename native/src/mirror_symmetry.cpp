// SPDX-License-Identifier: GPL-3.0-or-later
#include "mirror_symmetry.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "point_grid.h"

namespace arap {

namespace {

/// Sums that vanish for points mirrored along `axis`; cheap, and hardly any other mesh gets through.
bool may_be_mirrored(const Positions& rest, int axis) {
  const auto x = rest.col(axis).array();
  const auto y = rest.col((axis + 1) % 3).array();
  const auto z = rest.col((axis + 2) % 3).array();
  const std::array<double, 4> means{x.mean(), (x * y).mean(), (x * z).mean(), x.cube().mean()};
  for (const double mean : means)
    if (std::abs(mean) > kMirrorTolerance) return false;
  return true;
}

std::vector<int> find_images(const Positions& rest, const PointGrid& grid, int axis) {
  std::vector<int> images(rest.rows(), -1);
  for (int v = 0; v < static_cast<int>(rest.rows()); ++v) {
    Eigen::RowVector3d place = rest.row(v);
    place[axis] = -place[axis];
    double nearest = std::numeric_limits<double>::infinity();
    grid.for_each_near(place, kMirrorTolerance, [&](int candidate, double distance) {
      // Vertices at one place, as at an open seam: the lowest.
      if (distance > nearest || (distance == nearest && candidate > images[v])) return;
      nearest = distance;
      images[v] = candidate;
    });
    if (images[v] < 0) return {};
  }
  return images;
}

}  // namespace

std::vector<std::vector<int>> find_mirrors(const Positions& rest) {
  std::vector<std::vector<int>> mirrors;
  std::optional<PointGrid> grid;
  for (int axis = 0; axis < 3; ++axis) {
    if (!may_be_mirrored(rest, axis)) continue;
    if (!grid) grid.emplace(rest, 2 * kMirrorTolerance);
    std::vector<int> images = find_images(rest, *grid, axis);
    if (!images.empty()) mirrors.push_back(std::move(images));
  }
  return mirrors;
}

}  // namespace arap
