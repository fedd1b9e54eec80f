// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "arap/options.h"
#include "optimize/distance_estimate.h"
#include "optimize/local_global.h"
#include "optimize/soft_directions.h"
#include "optimize/time_budget.h"

namespace arap {

/// Tells when what should fall from iteration to iteration is rounding, and falls no more.
class RoundingTest {
 public:
  [[nodiscard]] bool is_lost(double value) {
    constexpr double kLess = 0.7;
    constexpr int kPatience = 30;
    if (value < kLess * least_) {
      least_ = value;
      n_since_ = 0;
    }
    return ++n_since_ > kPatience;
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  int n_since_ = 0;
};

/// Nonlinear conjugate gradients on E(p') = min_R E(p', R), preconditioned by the factorized matrix. The preconditioned
/// residual is the global step. With beta = 0 and length 1 an iteration is plain local/global: it is the first step,
/// and the fallback if a longer one raises the energy. It never raises it but where a term keeps volumes, which K does
/// not bound; then the length is halved until it falls. beta by Polak and Ribiere, not below 0; the length by the
/// secant of the slope at 0 and at the last length.
class NonlinearCg {
 public:
  explicit NonlinearCg(LocalGlobal& steps) : steps_(steps), soft_(steps) {}

  /// Discards the search directions: the next step is a plain global step. Call it after the targets or the pose were
  /// changed from outside; otherwise a new solve continues the previous search.
  void restart() {
    is_fresh_ = true;
    distance_.forget();
    soft_rounding_ = {};
  }
  /// The same, as if nothing had been solved before.
  void forget() {
    restart();
    soft_.forget();
  }

  /// One iteration from a fitted pose; returns the energy, which is not above `energy`, that of the pose, but by
  /// rounding.
  [[nodiscard]] double iterate(Pose& pose, double energy, Acceleration acceleration);

  /// Whether the pose, as fitted, is within the accuracy of the minimizer along soft directions, too. Where they are
  /// unknown they are found, as long as may_go_on().
  [[nodiscard]] bool is_soft_within(double accuracy, const Pose& pose, const SoftDirections::MayGoOn& may_go_on);

  /// The last iteration's largest movement of a vertex.
  [[nodiscard]] double step() const { return step_; }
  /// That of the global step where it began.
  [[nodiscard]] double longest_correction() const { return longest_row(correction_, steps_.workers()); }
  /// Estimated distance of the pose from the minimizer, from the last steps.
  [[nodiscard]] double distance() const { return distance_.value(); }

 private:
  using Steps = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

  using Sums = std::array<double, 3>;

  /// <z, r>, <z, last r> and <last direction, r>; the latter two 0 after a restart. Keeps r as the last one.
  [[nodiscard]] Sums sum_products(const Positions& residual);
  /// beta of the next direction, 0 for the plain global step; sets the slope along it.
  [[nodiscard]] double choose_beta();
  /// Slope of minus the energy along the direction, from the residual at hand.
  [[nodiscard]] double slope_along_direction() const;
  /// direction = correction + beta direction, and try_length along it.
  [[nodiscard]] double try_direction(Pose& pose, double length, double beta);
  /// Moves from the start by `length` along the direction and fits the rotations there; returns the energy.
  [[nodiscard]] double try_length(Pose& pose, double length);
  /// update(rows of the direction, begin, end) comes first, range by range.
  template <class Update>
  [[nodiscard]] double move(Pose& pose, double length, const Update& update);

  LocalGlobal& steps_;
  SoftDirections soft_;
  RoundingTest soft_rounding_;
  bool is_fresh_ = true;
  double length_ = 1;
  double slope_ = 0;  ///< of minus the energy at the start of the last step, along it
  double z_r_ = 0;    ///< <correction, residual> of the last iteration
  double step_ = 0;
  DistanceEstimate distance_;
  Positions start_;       ///< positions before the last step
  Positions correction_;  ///< the global step from there
  Steps residual_;        ///< there; rounded, as directions are: the step has few digits anyway
  Steps direction_;
  std::vector<Placement> placements_;  ///< before the last step
};

/// Whether a solve that is to come so near ends in double precision.
[[nodiscard]] bool ends_in_double(double accuracy);

/// Whether single precision cannot bring a pose at this distance from the minimizer to within the accuracy.
[[nodiscard]] bool needs_double(double distance, double accuracy);

struct IterationReport {
  double energy_before = 0;
  double energy_after = 0;
  int iterations = 0;
  double step = 0;
  StopReason stop_reason = StopReason::kMaxIterations;
};

/// Iterates from a pose until the options or `progress` stop it. At least one iteration is done.
/// @param search       over the steps; goes on with its directions, see NonlinearCg::restart()
/// @param time         of the whole solve, in place of the options' limit
/// @param step_before  where the pose comes from a global step: its largest movement. With the fit that comes first
///                     here it is an iteration, which `time` has seen begin.
/// @param on_first_fit is called after that fit
IterationReport minimize(LocalGlobal& steps, NonlinearCg& search, Pose& pose, const SolveOptions& options,
                         const Progress& progress, TimeBudget& time, std::optional<double> step_before,
                         const std::function<void()>& on_first_fit);

}  // namespace arap
