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

/// Triangles in hashed regular grids of several cell sizes, for short rays. Each triangle is in the finest grid whose
/// cells are at least as large as the triangle, so it is in at most eight cells.
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

  /// The first triangle that a ray crosses from behind between `nearest` and `farthest`, of those for which
  /// is_met(triangle) holds. Ignores triangles without area and triangles along the ray.
  /// @param direction  unit vector
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
          // A cheap test that rejects half of the triangles, and nearly all where a ray leaves a wall.
          if (!(members_[k].normal.dot(ahead) > 0)) continue;
          const int t = members_[k].triangle;
          if (is_met(triangles_[t])) meet(t, origin, direction, nearest, hit);
        }
      } while (walk.advance(hit.distance));
    }
    return hit;
  }

  /// Winding number of the triangles for which is_met(triangle) holds around a point, if they are closed: the number of
  /// triangles through which an axis-parallel ray leaves minus the number through which it enters. Exact also if the
  /// ray crosses an edge or a vertex.
  /// @param along  1 or -1: up or down the axis
  /// @param reach  length of the ray; there must be no triangles beyond
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
    Eigen::RowVector3f normal;  ///< unit, or 0 if the triangle has no area
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
    /// Goes to the next cell; false if it begins beyond `length`.
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
    std::array<double, 3> next_{};      ///< for each axis: position on the ray where the next cell begins
    std::array<double, 3> per_cell_{};  ///< for each axis: length of the ray per cell
  };

  /// Adds the cells of a triangle; returns its level.
  int find_cells(int triangle, std::vector<Entry>& entries) const;
  /// Replaces `hit` by the triangle if the ray crosses it earlier.
  void meet(int triangle, const Row& origin, const Row& direction, double nearest, Hit& hit) const;
  /// 1 if an axis-parallel ray leaves through the triangle, -1 if it enters, 0 if it does neither.
  [[nodiscard]] int pass(int triangle, const Row& place, int axis, int along) const;

  const Positions& points_;
  std::vector<Triangle> triangles_;
  double cell_size_;
  std::uint64_t mask_;
  std::vector<int> levels_;      ///< grids that have triangles
  std::vector<int> offsets_;     ///< of each slot
  std::vector<Member> members_;  ///< of the slots one after the other; cells may share a slot
};

}  // namespace arap
