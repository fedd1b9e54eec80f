// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/meter.h"

#include <algorithm>
#include <utility>

#include "arap/error.h"

namespace arap {

Progress part_of(const Progress& progress, double begin, double end) {
  if (!progress) return {};
  return [&progress, begin, end](double fraction) { return progress(begin + fraction * (end - begin)); };
}

Meter::Meter(const Progress& progress, std::string when_stopped)
    : progress_(progress),
      when_stopped_(std::move(when_stopped)),
      caller_(std::this_thread::get_id()),
      last_(std::chrono::steady_clock::now()) {}

void Meter::add(double part) {
  using namespace std::chrono_literals;
  if (!progress_) return;
  // Not fetch_add(), which older standard libraries lack for such numbers (Apple's).
  for (double done = done_; part > 0 && !done_.compare_exchange_weak(done, done + part);) continue;
  if (is_stopped_) std::rethrow_exception(reason_);
  if (std::this_thread::get_id() == caller_ && std::chrono::steady_clock::now() - last_ >= 100ms) tell();
}

void Meter::reach(double fraction) {
  double done = done_;
  while (done < fraction && !done_.compare_exchange_weak(done, fraction)) continue;
  tell();
}

void Meter::tell() {
  if (!progress_) return;
  last_ = std::chrono::steady_clock::now();
  told_ = std::max(told_, std::min<double>(done_, 1));
  try {
    if (!progress_(told_)) throw Cancelled(when_stopped_);
  } catch (...) {
    reason_ = std::current_exception();
    is_stopped_ = true;
    throw;
  }
}

}  // namespace arap
