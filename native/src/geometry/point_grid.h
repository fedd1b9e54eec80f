// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "arap/types.h"
#include "base/offsets.h"
#include "geometry/grid_cell.h"
#include "parallel/parallel.h"

namespace arap {

/// Points in a hashed regular grid, for searches nearby.
class PointGrid {
 public:
  /// @param points     (n, 3), kept by reference
  /// @param cell_size  > 0; about the distance of the searches
  /// @param threads    to work on
  PointGrid(const Positions& points, double cell_size, int threads)
      : points_(points),
        per_length_(1 / cell_size),
        mask_(std::bit_ceil(static_cast<std::uint64_t>(points.rows()) + 1) - 1),
        offsets_(mask_ + 2, 0),
        members_(points.rows()) {
    const auto n = static_cast<int>(points.rows());
    std::vector<std::uint64_t> slots(n);
    parallel_for(threads, n, [&](int begin, int end) {
      for (int v = begin; v < end; ++v) slots[v] = slot(cell_of(points.row(v)));
    });
    for (const std::uint64_t s : slots) ++offsets_[s + 1];
    make_offsets(offsets_);
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (int v = 0; v < n; ++v) members_[next[slots[v]]++] = v;
  }

  /// A point within `distance` of `place` for which is_wanted(v, squared distance) holds, -1 for none. Tests the points
  /// of a cell in ascending order and stops at the first match.
  template <class IsWanted>
  [[nodiscard]] int find_near(const Eigen::RowVector3d& place, double distance, const IsWanted& is_wanted) const {
    int found = -1;
    for_each_cell(cell_of(place.array() - distance), cell_of(place.array() + distance), [&](const GridCell& cell) {
      const std::uint64_t s = slot(cell);
      for (int k = offsets_[s]; k < offsets_[s + 1] && found < 0; ++k) {
        const Eigen::RowVector3d point = points_.row(members_[k]);
        const double squared = (point - place).squaredNorm();
        // Cells may share a slot, even two cells of this search.
        if (squared <= distance * distance && cell_of(point) == cell && is_wanted(members_[k], squared))
          found = members_[k];
      }
    });
    return found;
  }

 private:
  [[nodiscard]] GridCell cell_of(const Eigen::RowVector3d& point) const { return grid_cell(point, per_length_); }
  [[nodiscard]] std::uint64_t slot(const GridCell& cell) const { return grid_hash(cell) & mask_; }

  const Positions& points_;
  double per_length_;
  std::uint64_t mask_;
  std::vector<int> offsets_;  ///< of each slot
  std::vector<int> members_;
};

}  // namespace arap
