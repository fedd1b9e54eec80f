// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/options.h"
#include "local_global.h"

namespace arap {

/// Nonlinear conjugate gradients on E(p') = min_R E(p', R), preconditioned by the factorized matrix. The preconditioned
/// residual is the global step, so with beta = 0 and length 1 an iteration is plain local/global, which never raises
/// the energy: it is the first step, and the way out wherever a longer one raises it. beta by Polak and Ribiere, not
/// below 0; the length by the secant of the slope at 0 and at the last length.
class NonlinearCg {
 public:
  explicit NonlinearCg(LocalGlobal& steps) : steps_(steps) {}

  /// Forgets the directions so far: the next step is a plain global step.
  void restart() { is_fresh_ = true; }

  /// One iteration from a fitted pose; returns the energy, which is not above `energy`, that of the pose, but by
  /// rounding.
  [[nodiscard]] double iterate(Pose& pose, double energy);

  /// The longer of the last movement and the plain global step there, of any vertex.
  [[nodiscard]] double step() const { return step_; }
  /// Upper bound of the decrease of the energy in the last iteration, from the slope at its start.
  [[nodiscard]] double promised_decrease() const { return promised_decrease_; }

 private:
  /// Sets the direction; returns the slope of minus the energy along it.
  [[nodiscard]] double choose_direction();
  /// Moves from the start by `length` along the direction and fits the rotations there; returns the energy.
  [[nodiscard]] double try_length(Pose& pose, double length);
  /// direction = correction + beta direction; notes the longest rows.
  void update_direction(double beta);

  LocalGlobal& steps_;
  bool is_fresh_ = true;
  double length_ = 1;
  double z_r_ = 0;  ///< <correction, residual> of the last iteration
  double step_ = 0;
  double promised_decrease_ = 0;
  double longest_correction_ = 0;
  double longest_direction_ = 0;
  Positions start_;       ///< positions before the last step
  Positions residual_;    ///< there
  Positions correction_;  ///< the plain global step from there
  Positions direction_;
  std::vector<Placement> placements_;  ///< before the last step
};

struct IterationReport {
  double energy_before = 0;
  double energy_after = 0;
  int iterations = 0;
  double step = 0;
  StopReason stop_reason = StopReason::kMaxIterations;
};

/// Iterates from a pose until the options or `progress` stop it.
/// @param search  over the steps
IterationReport minimize(LocalGlobal& steps, NonlinearCg& search, Pose& pose, const SolveOptions& options,
                         const Progress& progress);

}  // namespace arap
