// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <exception>

namespace arap {

/// Captures the first exception of parallel work and rethrows it on the calling thread.
class FirstFailure {
 public:
  /// Calls act() and captures its exception. Does nothing after a failure.
  template <class Act>
  void guard(const Act& act) {
    if (has_failed_) return;
    try {
      act();
    } catch (...) {
      if (!has_failed_.exchange(true)) exception_ = std::current_exception();
    }
  }

  /// Notes a failure without an exception.
  void note() { has_failed_ = true; }
  [[nodiscard]] bool has_happened() const { return has_failed_; }

  /// Rethrows the captured exception, if any. Call when the threads are done.
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::atomic<bool> has_failed_ = false;
  std::exception_ptr exception_;
};

}  // namespace arap
