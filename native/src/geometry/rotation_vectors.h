// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <span>

#include "arap/types.h"

namespace arap {

/// Rotations as vectors: the axis times the angle in radian.

[[nodiscard]] inline Eigen::Quaterniond rotation_by(const Vector3& turn) {
  const double angle = turn.norm();
  if (!(angle > 0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle));
}

/// cos(a) and sin(a) / a.
struct CosineAndSinc {
  double cosine;
  double sinc;
};

/// @param squared  a^2, up to 2.5: there the series that are cut are right to 1e-16
[[nodiscard]] inline CosineAndSinc cosine_and_sinc(double squared) {
  constexpr int kTerms = 11;
  CosineAndSinc sums{1, 1};
  for (int k = 2 * kTerms; k > 0; k -= 2) {
    sums.cosine = 1 - squared * (1.0 / (k * (k - 1))) * sums.cosine;
    sums.sinc = 1 - squared * (1.0 / (k * (k + 1))) * sums.sinc;
  }
  return sums;
}

/// R - I, exact also for small turns: with c = cos(a / 2), s = sin(a / 2) / a, that is 2 s (c [t]x + s [t]x^2).
[[nodiscard]] inline Matrix3 rotation_less_identity(const Vector3& turn) {
  constexpr double kSeries = 10;  // just above half a turn
  const double squared = turn.squaredNorm();
  CosineAndSinc half{};
  if (squared < kSeries) {
    half = cosine_and_sinc(squared / 4);
  } else {
    const double angle = std::sqrt(squared) / 2;
    half = {std::cos(angle), std::sin(angle) / angle};
  }
  const Vector3 t = (half.sinc * half.cosine) * turn;
  const Vector3 u = (half.sinc * half.sinc / 2) * turn;
  Matrix3 result = u * turn.transpose();
  result.diagonal().array() -= u.dot(turn);
  result(2, 1) += t[0];
  result(1, 2) -= t[0];
  result(0, 2) += t[1];
  result(2, 0) -= t[1];
  result(1, 0) += t[2];
  result(0, 1) -= t[2];
  return result;
}

/// (n, 3) vectors of matrices that need not be quite rotations, of half a turn at most. Where several are nearly half a
/// turn, for which one way round is as short as the other, all of them go the same way.
[[nodiscard]] Positions rotation_vectors(std::span<const Matrix3> rotations);

/// Replaces vectors by others of the same rotations, which are whole turns longer or shorter: those nearest to the
/// `last` ones. So a rotation that is followed in steps below half a turn may turn as far as it likes.
/// @param last, turns  (n, 3)
void go_on_from(const Positions& last, Positions& turns);

}  // namespace arap
