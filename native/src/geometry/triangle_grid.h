// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "arap/types.h"
#include "geometry/grid_cell.h"

namespace arap {

/// Triangles in the cells of regular grids, for asking through which one a short ray leaves. Each triangle is in the
/// finest grid whose cells are no smaller than it, so that it is in at most eight of them.
class TriangleGrid {
 public:
  using Triangle = std::array<int, 3>;
  using Row = Eigen::RowVector3d;

  struct Hit {
    int triangle = -1;  ///< -1: none
    double distance = std::numeric_limits<double>::infinity();
    double facing = 0;  ///< cosine between the ray and the triangle's normal
  };

  /// @param points     (n, 3), kept by reference
  /// @param cell_size  > 0, of the finest grid
  TriangleGrid(const Positions& points, std::vector<Triangle> triangles, double cell_size, int threads);

  [[nodiscard]] const Triangle& triangle(int index) const { return triangles_[index]; }

  /// What a ray meets first from behind between `nearest` and `farthest`, of the triangles for which is_met(triangle).
  /// Triangles without area, or along the ray, are met by none.
  /// @param direction  of length 1
  template <class IsMet>
  [[nodiscard]] Hit first_exit(const Row& origin, const Row& direction, double nearest, double farthest,
                               const IsMet& is_met) const {
    const Eigen::RowVector3f ahead = direction.cast<float>();
    Hit hit;
    hit.distance = farthest;
    for (const int level : levels_) {
      Walk walk(origin, direction, hit.distance, size_of(level));
      do {
        const std::uint64_t s = slot(level, walk.cell());
        for (int k = offsets_[s]; k < offsets_[s + 1]; ++k) {
          // Half of the triangles, and nearly all where a ray leaves a wall, are done with after this.
          if (!(members_[k].normal.dot(ahead) > 0)) continue;
          const int t = members_[k].triangle;
          if (is_met(triangles_[t])) meet(t, origin, direction, nearest, hit);
        }
      } while (walk.advance(hit.distance));
    }
    return hit;
  }

  /// How often the triangles for which is_met(triangle) wind around a place, where they are closed: those that a ray
  /// along an axis leaves through less those that it enters by. Exact where two triangles meet.
  /// @param along  1 or -1: up or down the axis
  /// @param reach  of the ray; there is nothing beyond
  template <class IsMet>
  [[nodiscard]] int winding(const Row& place, int axis, int along, double reach, const IsMet& is_met) const {
    int sum = 0;
    std::vector<int> met;  // a triangle is in several cells
    for (const int level : levels_) {
      Walk walk(place, along * Row::Unit(axis), reach, size_of(level));
      do {
        const std::uint64_t s = slot(level, walk.cell());
        for (int k = offsets_[s]; k < offsets_[s + 1]; ++k) {
          const int t = members_[k].triangle;
          const int passed = is_met(triangles_[t]) ? pass(t, place, axis, along) : 0;
          if (passed == 0 || std::find(met.begin(), met.end(), t) != met.end()) continue;
          met.push_back(t);
          sum += passed;
        }
      } while (walk.advance(reach));
    }
    return sum;
  }

 private:
  struct Member {
    int triangle = -1;
    Eigen::RowVector3f normal;  ///< unit; 0 where there is none
  };

  struct Entry {
    std::uint64_t slot = 0;
    Member member;
  };

  [[nodiscard]] double size_of(int level) const { return std::ldexp(cell_size_, level); }
  [[nodiscard]] std::uint64_t slot(int level, const GridCell& cell) const { return grid_hash(cell, level) & mask_; }

  /// The cells along a ray, one after the other.
  class Walk {
   public:
    Walk(const Row& origin, const Row& direction, double length, double cell_size);
    [[nodiscard]] const GridCell& cell() const { return cell_; }
    /// Whether there is a next cell that begins within `length`.
    bool advance(double length) {
      const int axis = next_[0] < next_[1] ? (next_[0] < next_[2] ? 0 : 2) : (next_[1] < next_[2] ? 1 : 2);
      if (!(next_[axis] <= length)) return false;
      cell_[axis] += step_[axis];
      next_[axis] += per_cell_[axis];
      return true;
    }

   private:
    GridCell cell_{};
    GridCell step_{};
    std::array<double, 3> next_{};      ///< where on the ray the next cell along each axis begins
    std::array<double, 3> per_cell_{};  ///< length of the ray in a cell
  };

  /// Adds the cells of a triangle; returns its level.
  int find_cells(int triangle, std::vector<Entry>& entries) const;
  /// Puts the triangle in the place of `hit` where it is met sooner.
  void meet(int triangle, const Row& origin, const Row& direction, double nearest, Hit& hit) const;
  /// 1 where a ray along an axis leaves through the triangle, -1 where it enters by it, 0 where it does neither.
  [[nodiscard]] int pass(int triangle, const Row& place, int axis, int along) const;

  const Positions& points_;
  std::vector<Triangle> triangles_;
  double cell_size_;
  std::uint64_t mask_;
  std::vector<int> levels_;      ///< that have triangles
  std::vector<int> offsets_;     ///< of each slot
  std::vector<Member> members_;  ///< cells may share a slot: what else is in it is not met
};

}  // namespace arap
