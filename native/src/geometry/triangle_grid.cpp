// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/triangle_grid.h"

#include <Eigen/Geometry>
#include <bit>
#include <utility>

#include "base/offsets.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Triangles are enlarged by this part: rays must not slip through between two.
constexpr double kMargin = 1e-3;
/// Number of grids; each has cells twice the size of the one before.
constexpr int kLevels = 60;

/// 1 if the edge from a to b goes up to the right of the origin, -1 if it goes down there, else 0. Computed from the
/// lower vertex index to the higher one, so that an edge that two triangles share is on the same side of the origin for
/// both.
int turn_past(int a, int b, const Eigen::Vector2d& place_of_a, const Eigen::Vector2d& place_of_b) {
  const bool goes_up = place_of_b[1] > 0;
  if (goes_up == (place_of_a[1] > 0)) return 0;
  const Eigen::Vector2d& low = a < b ? place_of_a : place_of_b;
  const Eigen::Vector2d& high = a < b ? place_of_b : place_of_a;
  const bool is_left = low[0] * high[1] - high[0] * low[1] > 0;
  if (is_left != (high[1] > 0)) return 0;
  return goes_up ? 1 : -1;
}

}  // namespace

TriangleGrid::TriangleGrid(const Positions& points, std::vector<Triangle> triangles, double cell_size, int threads)
    : points_(points),
      triangles_(std::move(triangles)),
      cell_size_(cell_size),
      mask_(std::bit_ceil(triangles_.size() + 1) - 1),
      offsets_(mask_ + 2, 0) {
  constexpr int kRange = 4096;
  const auto n = static_cast<int>(triangles_.size());
  std::vector<std::vector<Entry>> pieces((triangles_.size() + kRange - 1) / kRange);
  std::vector<std::uint64_t> levels(pieces.size(), 0);  // one bit per level
  parallel_for_ranges(threads, n, kRange, [&](int begin, int end) {
    for (int t = begin; t < end; ++t)
      levels[begin / kRange] |= std::uint64_t{1} << static_cast<unsigned>(find_cells(t, pieces[begin / kRange]));
  });
  std::uint64_t all = 0;
  for (const std::uint64_t level : levels) all |= level;
  for (int level = 0; level < kLevels; ++level)
    if ((all >> static_cast<unsigned>(level) & 1U) != 0) levels_.push_back(level);
  for (const std::vector<Entry>& piece : pieces)
    for (const Entry& entry : piece) ++offsets_[entry.slot + 1];
  make_offsets(offsets_);
  members_.resize(offsets_.back());
  std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
  for (const std::vector<Entry>& piece : pieces)
    for (const Entry& entry : piece) members_[next[entry.slot]++] = entry.member;
}

int TriangleGrid::find_cells(int triangle, std::vector<Entry>& entries) const {
  const auto& [a, b, c] = triangles_[triangle];
  const Row first = points_.row(a);
  const Row second = points_.row(b);
  const Row third = points_.row(c);
  const Row normal = Row(second - first).cross(Row(third - first)).normalized();
  Row low = first.cwiseMin(second).cwiseMin(third);
  Row high = first.cwiseMax(second).cwiseMax(third);
  const double margin = kMargin * (high - low).maxCoeff();
  low.array() -= margin;
  high.array() += margin;
  const double parts = (high - low).maxCoeff() / cell_size_;
  const int level = parts <= 1 ? 0 : std::min(static_cast<int>(std::ceil(std::log2(parts))), kLevels - 1);
  const double per_length = 1 / size_of(level);
  for_each_cell(grid_cell(low, per_length), grid_cell(high, per_length), [&](const GridCell& cell) {
    entries.push_back({slot(level, cell), {triangle, normal.cast<float>()}});
  });
  return level;
}

TriangleGrid::Walk::Walk(const Row& origin, const Row& direction, double length, double cell_size) {
  for (int axis = 0; axis < 3; ++axis) {
    const double place = origin[axis] / cell_size;
    cell_[axis] = static_cast<std::int64_t>(std::floor(place));
    step_[axis] = direction[axis] < 0 ? -1 : 1;
    const double speed = std::abs(direction[axis]) / cell_size;
    const double ahead = direction[axis] < 0 ? place - std::floor(place) : std::floor(place) + 1 - place;
    // The ray does not reach the next cell along this axis.
    const bool stays = !(speed * length > ahead);
    next_[axis] = stays ? std::numeric_limits<double>::infinity() : ahead / speed;
    per_cell_[axis] = stays ? 0 : 1 / speed;
  }
}

void TriangleGrid::meet(int triangle, const Row& origin, const Row& direction, double nearest, Hit& hit) const {
  // Moeller, Trumbore: Fast, Minimum Storage Ray/Triangle Intersection, 1997.
  const auto& [a, b, c] = triangles_[triangle];
  const Row first = points_.row(a);
  const Row along = points_.row(b) - first;
  const Row other = points_.row(c) - first;
  const Row normal = along.cross(other);
  const double facing = normal.dot(direction);
  const double squared = normal.squaredNorm();
  constexpr double kSliver = 1e-5;  // height over length, and sine of the angle between ray and triangle
  if (!(squared > kSliver * kSliver * along.squaredNorm() * other.squaredNorm())) return;
  if (!(facing > 0 && facing * facing > kSliver * kSliver * squared)) return;
  const Row start = origin - first;
  const Row turned = start.cross(direction);
  const double distance = -normal.dot(start) / facing;
  if (!(distance > nearest && distance < hit.distance)) return;
  const double u = -other.dot(turned) / facing;
  const double v = along.dot(turned) / facing;
  if (!(u >= -kMargin && v >= -kMargin && u + v <= 1 + kMargin)) return;
  hit = {triangle, distance, facing / std::sqrt(squared)};
}

int TriangleGrid::pass(int triangle, const Row& place, int axis, int along) const {
  const Triangle& corners = triangles_[triangle];
  std::array<Eigen::Vector3d, 3> p;
  std::array<Eigen::Vector2d, 3> seen;  // along the axis
  for (int k = 0; k < 3; ++k) {
    p[k] = (points_.row(corners[k]) - place).transpose();
    seen[k] = {p[k][(axis + 1) % 3], p[k][(axis + 2) % 3]};
  }
  int turns = 0;
  for (int k = 0; k < 3; ++k) turns += turn_past(corners[k], corners[(k + 1) % 3], seen[k], seen[(k + 1) % 3]);
  if (turns == 0) return 0;
  const bool is_above = (p[0].dot(p[1].cross(p[2])) > 0) == (turns > 0);
  return is_above == (along > 0) ? along * turns : 0;
}

}  // namespace arap
