// SPDX-License-Identifier: GPL-3.0-or-later
#include "mirror_symmetry.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "parallel.h"
#include "point_grid.h"

namespace arap {

namespace {

/// Of the grid: what is asked for is small beside it, so that it is nearly always in one cell.
constexpr double kCell = 8 * kMirrorTolerance;

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

/// The vertex nearest to a place, -1 where none is near.
int find_near(const PointGrid& grid, const Eigen::RowVector3d& place) {
  int near = -1;
  double nearest = std::numeric_limits<double>::infinity();
  grid.for_each_near(place, kMirrorTolerance, [&](int candidate, double distance) {
    // Vertices at one place, as at an open seam: the lowest.
    if (distance > nearest || (distance == nearest && candidate > near)) return;
    nearest = distance;
    near = candidate;
  });
  return near;
}

/// Empty where a vertex has none.
std::vector<int> find_images(const Positions& rest, const PointGrid& grid, int axis, int threads) {
  std::vector<int> images(rest.rows());
  const bool all_found = parallel_all(threads, static_cast<int>(rest.rows()), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Eigen::RowVector3d place = rest.row(v);
      place[axis] = -place[axis];
      images[v] = find_near(grid, place);
      if (images[v] < 0) return false;
    }
    return true;
  });
  return all_found ? images : std::vector<int>();
}

}  // namespace

std::vector<std::vector<int>> find_mirrors(const Positions& rest, int threads) {
  std::vector<std::vector<int>> mirrors;
  std::optional<PointGrid> grid;
  for (int axis = 0; axis < 3; ++axis) {
    if (!may_be_mirrored(rest, axis)) continue;
    if (!grid) grid.emplace(rest, kCell, threads);
    std::vector<int> images = find_images(rest, *grid, axis, threads);
    if (!images.empty()) mirrors.push_back(std::move(images));
  }
  return mirrors;
}

}  // namespace arap
