// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

namespace arap {

/// Whether a solve has time for another iteration, as far as those that it has had can tell.
class TimeBudget {
 public:
  /// The time in seconds, since whenever.
  using Clock = std::function<double()>;
  [[nodiscard]] static double steady_seconds();

  /// The solve starts now. @param limit_s  what all of it may take; infinity: no limit
  explicit TimeBudget(double limit_s, Clock clock = steady_seconds);

  /// The next iteration starts now; without a call, where the last one ended.
  void begin_iteration();
  void end_iteration();

  /// False where time is up, or would be before the next iteration ended, if that took as long as the last ones did:
  /// the median of up to five, of two in the middle the shorter, so that a single one that had to wait for its core
  /// counts little.
  [[nodiscard]] bool allows_another() const;

 private:
  Clock clock_;
  double limit_s_;
  double start_s_;
  double iteration_start_s_;
  std::vector<double> last_s_;  ///< durations of the last iterations, the latest last
};

}  // namespace arap
