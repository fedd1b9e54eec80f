// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace arap {

/// How far an iteration still is from where it would end, as far as its last steps tell: with steps that become shorter
/// at an even rate, the sum of all that follow.
class DistanceEstimate {
 public:
  void forget() { n_ = 0; }

  /// Comes after an iteration.
  /// @param step      largest movement of a vertex
  /// @param decrease  of the energy, the square of the step's length in the energy's own norm: it counts every vertex,
  ///                  so that it tells the rate better than the largest movement
  void add(double step, double decrease);

  /// Infinity before the first step.
  [[nodiscard]] double value() const;

 private:
  struct Step {
    double length;
    double decrease;
  };
  static constexpr int kLast = 10;  ///< conjugate gradients go in waves: fewer steps would tell where in one they are

  /// By how much an iteration shortens the steps, in (0, 1).
  [[nodiscard]] double rate() const;
  /// `ago` steps before the last one.
  [[nodiscard]] const Step& step(int ago) const { return steps_[(n_ - 1 - ago) % kLast]; }

  std::array<Step, kLast> steps_{};
  int n_ = 0;
};

}  // namespace arap
