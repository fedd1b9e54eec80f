// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/time_budget.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace arap {

namespace {

/// Iterations that are remembered.
constexpr size_t kMost = 5;

}  // namespace

double TimeBudget::steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

TimeBudget::TimeBudget(double limit_s, Clock clock)
    : clock_(std::move(clock)), limit_s_(limit_s), start_s_(clock_()), iteration_start_s_(start_s_) {
  last_s_.reserve(kMost);
}

void TimeBudget::begin_iteration() { iteration_start_s_ = clock_(); }

void TimeBudget::end_iteration() {
  if (last_s_.size() == kMost) last_s_.erase(last_s_.begin());
  const double now_s = clock_();
  last_s_.push_back(now_s - iteration_start_s_);
  iteration_start_s_ = now_s;
}

bool TimeBudget::allows_another() const {
  const double left_s = limit_s_ - (clock_() - start_s_);
  if (last_s_.empty()) return left_s > 0;
  std::vector<double> sorted = last_s_;
  const auto median = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
  std::nth_element(sorted.begin(), median, sorted.end());
  return left_s > 0 && *median <= left_s;
}

}  // namespace arap
