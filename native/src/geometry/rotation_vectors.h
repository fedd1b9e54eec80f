// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "arap/types.h"

namespace arap {

/// Rotations as vectors: the axis times the angle in radian.

[[nodiscard]] inline Eigen::Quaterniond rotation_by(const Vector3& turn) {
  const double angle = turn.norm();
  if (!(angle > 0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle));
}

/// (n, 3) vectors of matrices that need not be quite rotations, of half a turn at most. Where several are nearly half a
/// turn, for which one way round is as short as the other, all of them go the same way.
[[nodiscard]] Positions rotation_vectors(std::span<const Matrix3> rotations);

/// Replaces vectors by others of the same rotations, which are whole turns longer or shorter: those nearest to the
/// `last` ones. So a rotation that is followed in steps below half a turn may turn as far as it likes.
/// @param last, turns  (n, 3)
void go_on_from(const Positions& last, Positions& turns);

}  // namespace arap
