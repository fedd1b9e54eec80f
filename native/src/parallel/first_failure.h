// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <exception>

namespace arap {

/// Of work on several threads, which no exception may leave: the first failure stops the rest and is told afterwards.
class FirstFailure {
 public:
  /// Calls act() and keeps what it throws; does nothing once something has failed.
  template <class Act>
  void guard(const Act& act) {
    if (has_failed_) return;
    try {
      act();
    } catch (...) {
      if (!has_failed_.exchange(true)) exception_ = std::current_exception();
    }
  }

  /// Something has failed without an exception.
  void note() { has_failed_ = true; }
  [[nodiscard]] bool has_happened() const { return has_failed_; }

  /// Once the threads are done: throws what was kept, if anything was.
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::atomic<bool> has_failed_ = false;
  std::exception_ptr exception_;
};

}  // namespace arap
