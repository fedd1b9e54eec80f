// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

namespace arap {

/// Threads for passes of microseconds to milliseconds, which a drag does hundreds of times a second. Copies share them;
/// the last copy ends them.
///
/// A pass is cut into pieces that threads claim one by one, the calling thread with them. It waits for nobody but who
/// is at work on a piece: a thread that the system has not put on a core yet is not missed. Threads without work spin
/// for a moment, then offer their core to others, then sleep; they start with the first pass that is worth it. Where
/// they cannot be had (no more threads, the child of a fork), and where they are busy with the pass of another caller,
/// the calling thread does all pieces itself.
class Workers {
 public:
  /// @param threads  >= 1, the calling one included
  explicit Workers(int threads = 1);

  [[nodiscard]] int threads() const { return threads_; }

  /// Calls body(piece) once for each of [0, n_pieces) and returns when all are done. `body` must not throw.
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
