// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/rotation_vectors.h"

#include <cmath>
#include <numbers>
#include <optional>

#include "geometry/rotation.h"

namespace arap {

namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;

/// From here on the other way round is nearly as short.
constexpr double kNearlyHalf = 170 * std::numbers::pi / 180;

}  // namespace

Positions rotation_vectors(std::span<const Matrix3> rotations) {
  Positions result(rotations.size(), 3);
  std::optional<Vector3> way;
  for (size_t k = 0; k < rotations.size(); ++k) {
    if (k > 0 && rotations[k] == rotations[k - 1]) {  // as in the rows of a handle, of which there may be thousands
      result.row(k) = result.row(k - 1);
      continue;
    }
    const Eigen::AngleAxisd turn(nearest_rotation(rotations[k], Matrix3::Identity()));
    double angle = turn.angle();
    if (angle > kNearlyHalf) {
      if (!way) way = turn.axis();
      if (way->dot(turn.axis()) < 0) angle -= kWholeTurn;
    }
    result.row(k) = angle * turn.axis().transpose();
  }
  return result;
}

void go_on_from(const Positions& last, Positions& turns) {
  constexpr double kNone = 1e-9;  // radian: a rotation without an axis of its own
  for (Eigen::Index k = 0; k < turns.rows(); ++k) {
    const double angle = turns.row(k).norm();
    const Eigen::RowVector3d axis =
        angle > kNone ? Eigen::RowVector3d(turns.row(k) / angle) : Eigen::RowVector3d(last.row(k).normalized());
    const double way = last.row(k).dot(axis) - angle;
    // What is about as near as the nearest one keeps the way that several have in common.
    if (std::abs(way) > kWholeTurn - kNearlyHalf) turns.row(k) += kWholeTurn * std::round(way / kWholeTurn) * axis;
  }
}

}  // namespace arap
