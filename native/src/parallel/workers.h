// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <exception>
#include <memory>

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

/// A pool of threads for passes of microseconds to milliseconds, hundreds of them a second during a drag. Copies share
/// the pool; the last copy ends it.
///
/// A pass is cut into pieces that the threads and the caller claim one by one. The caller waits only for threads that
/// hold a piece; a thread that is not scheduled does not delay it. Idle threads spin for a moment, then yield, then
/// sleep. They start with the first pass of more than one piece. If threads are not available (system limit, forked
/// child) or busy with the pass of another caller, the caller does all pieces itself.
class Workers {
 public:
  /// @param threads  >= 1, including the calling thread
  explicit Workers(int threads = 1);

  [[nodiscard]] int threads() const { return threads_; }

  /// Calls body(piece) once for each of [0, n_pieces) and returns when all are done. Rethrows the first exception,
  /// after which no piece is started.
  template <class Body>
  void run(int n_pieces, const Body& body) const {
    if (n_pieces > 1 && pool_ != nullptr)
      run_on(*pool_, n_pieces, {[](const void* b, int piece) { (*static_cast<const Body*>(b))(piece); }, &body});
    else
      for (int piece = 0; piece < n_pieces; ++piece) body(piece);
  }

 private:
  class Pool;
  struct Task {
    void (*call)(const void* body, int piece);
    const void* body;
  };

  static void run_on(Pool& pool, int n_pieces, const Task& task);

  int threads_;
  std::shared_ptr<Pool> pool_;  ///< null for one thread
};

}  // namespace arap
