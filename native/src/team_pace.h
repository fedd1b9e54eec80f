// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace arap {

/// Whether a team is worth it now, for work that is done again and again and gives the same result with any number of
/// threads. Where other processes want the cores, a team waits a time slice, milliseconds, for each member that has
/// lost its core; one thread alone does not. So how long the work takes alone is measured first, and a team that took
/// longer has to stay away, the longer the more often that happens.
class TeamPace {
 public:
  /// Threads for the next time.
  [[nodiscard]] int choose(int most) {
    if (most <= 1 || n_alone_ < kFirstAlone) return 1;
    if (turns_away_ == 0) return most;
    --turns_away_;
    return 1;
  }

  void record(int n_threads, double seconds) {
    if (n_threads <= 1) {
      // The first time is the slowest: nothing is in the caches.
      alone_ = n_alone_ == 0 || seconds < alone_ ? seconds : alone_ + (seconds - alone_) / kSlowly;
      if (n_alone_ < kFirstAlone) ++n_alone_;
    } else if (seconds > kMuchSlower * alone_ + kWaking) {
      turns_away_ = next_turns_away_;
      if (next_turns_away_ < kMostAway) next_turns_away_ *= 2;
    } else if (next_turns_away_ > kLeastAway) {
      --next_turns_away_;
    }
  }

 private:
  static constexpr int kFirstAlone = 2;
  static constexpr int kSlowly = 16;
  static constexpr double kMuchSlower = 2;
  static constexpr double kWaking = 5e-4;  ///< seconds that a sleeping member may take to come
  static constexpr int kLeastAway = 8;
  static constexpr int kMostAway = 256;

  int n_alone_ = 0;
  double alone_ = 0;  ///< seconds
  int turns_away_ = 0;
  int next_turns_away_ = kLeastAway;
};

}  // namespace arap
