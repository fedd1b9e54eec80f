// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "arap/types.h"

namespace arap {

/// Points in the cells of a regular grid, for asking what is near.
class PointGrid {
 public:
  /// @param points     (n, 3), kept by reference
  /// @param cell_size  > 0; about the distance that is asked for
  PointGrid(const Positions& points, double cell_size)
      : points_(points),
        per_length_(1 / cell_size),
        mask_(std::bit_ceil(static_cast<std::uint64_t>(points.rows()) + 1) - 1),
        offsets_(mask_ + 2, 0),
        members_(points.rows()) {
    const auto n = static_cast<int>(points.rows());
    std::vector<std::uint64_t> slots(n);
    for (int v = 0; v < n; ++v) {
      const Cell cell = cell_of(points.row(v));
      slots[v] = slot(cell[0], cell[1], cell[2]);
      ++offsets_[slots[v] + 1];
    }
    for (size_t s = 1; s < offsets_.size(); ++s) offsets_[s] += offsets_[s - 1];
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (int v = 0; v < n; ++v) members_[next[slots[v]]++] = v;
  }

  /// visit(v, squared distance) for every point within `distance` of `place`.
  template <class Visit>
  void for_each_near(const Eigen::RowVector3d& place, double distance, const Visit& visit) const {
    const Cell low = cell_of(place.array() - distance);
    const Cell high = cell_of(place.array() + distance);
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const std::uint64_t s = slot(x, y, z);
          for (int k = offsets_[s]; k < offsets_[s + 1]; ++k) {
            const Eigen::RowVector3d point = points_.row(members_[k]);
            // Cells far away may share the slot.
            if (cell_of(point) != Cell{x, y, z}) continue;
            const double squared = (point - place).squaredNorm();
            if (squared <= distance * distance) visit(members_[k], squared);
          }
        }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  [[nodiscard]] Cell cell_of(const Eigen::RowVector3d& point) const {
    return {static_cast<std::int64_t>(std::floor(point[0] * per_length_)),
            static_cast<std::int64_t>(std::floor(point[1] * per_length_)),
            static_cast<std::int64_t>(std::floor(point[2] * per_length_))};
  }
  [[nodiscard]] std::uint64_t slot(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const std::uint64_t mixed = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^
                                static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL ^
                                static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ULL;
    return (mixed ^ mixed >> 32U) & mask_;
  }

  const Positions& points_;
  double per_length_;
  std::uint64_t mask_;
  std::vector<int> offsets_;  ///< of each slot
  std::vector<int> members_;
};

}  // namespace arap
