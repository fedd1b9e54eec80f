// SPDX-License-Identifier: GPL-3.0-or-later
#include "turn_prediction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "parallel.h"

namespace arap {

void TurnPrediction::learn(const Positions& step, Rotations& before, Rotations& after) {
  if (step.rows() > 0 && (step.array() == 0).all()) return;
  last_step_ = step;
  before_.swap(before);
  after_.swap(after);
}

double TurnPrediction::share(const Positions& step) const {
  // Above 1 what is ahead grows from frame to frame; a drag that gets faster needs a little of it.
  constexpr double kMost = 1.5;
  if (step.rows() != last_step_.rows()) return 0;
  const double length_squared = last_step_.squaredNorm();
  if (!(length_squared > 0)) return 0;
  return std::clamp(last_step_.cwiseProduct(step).sum() / length_squared, -kMost, kMost);
}

void TurnPrediction::apply(double share, const Workers& workers, Rotations& rotations) const {
  constexpr double kLargestTurn = std::numbers::pi / 8;
  parallel_for(workers, static_cast<int>(rotations.size()), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      // Along the chord, which is half the turn: off from the arc by its third power.
      const Eigen::Vector4d now = rotations[c].coeffs();
      const Eigen::Vector4d next = (after_[c] * before_[c].conjugate() * rotations[c]).coeffs();
      const Eigen::Vector4d chord = share * ((now.dot(next) < 0 ? -1 : 1) * next - now);
      const double turn = 2 * chord.norm();
      rotations[c].coeffs() = (now + (turn > kLargestTurn ? kLargestTurn / turn : 1) * chord).normalized();
    }
  });
}

}  // namespace arap
