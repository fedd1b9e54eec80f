// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <span>

#include "arap/types.h"

namespace arap {

/// What the faces share that move points with something else: a cage, a surface. All checks throw InvalidInput.

/// At least one, not too many, finite.
/// @param carrier  what moves them
void require_points(const Positions& points, const char* carrier);

/// Of what moves the points.
/// @param what  the argument
void require_moved(const char* what, const Positions& positions, int n_vertices);

/// Of arrays without a shape.
/// @param noun  what has three numbers; there are n of them
void require_three_numbers(const char* what, size_t size, const char* noun, int n);

/// Points in single precision, row by row, that threads write to.
class SinglePoints {
 public:
  /// @param what  the argument that they come from, for the message
  SinglePoints(const char* what, std::span<float> out, int n_points);

  void put(int point, const Vector3& place) {
    const Eigen::Vector3f single = place.cast<float>();
    Eigen::Vector3f::Map(&out_[3 * static_cast<size_t>(point)]) = single;
    if (!single.allFinite()) is_finite_ = false;
  }
  /// Call it when all are put.
  void require_finite() const;

 private:
  const char* what_;
  std::span<float> out_;
  std::atomic<bool> is_finite_ = true;
};

}  // namespace arap
