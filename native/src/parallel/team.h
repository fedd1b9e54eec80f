// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <omp.h>

#include <atomic>
#include <thread>

#include "parallel/parallel.h"

namespace arap {

/// A barrier for work of microseconds: spins for a short time, then yields, because the missing thread may need the
/// core.
class SpinBarrier {
 public:
  void wait(int n_threads) {
    const unsigned generation = generation_.load(std::memory_order_acquire);
    if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == n_threads) {
      arrived_.store(0, std::memory_order_relaxed);
      generation_.store(generation + 1, std::memory_order_release);
      return;
    }
    for (int spins = 0; generation_.load(std::memory_order_acquire) == generation; ++spins) {
      if (spins < kSpins)
        pause();
      else
        std::this_thread::yield();
    }
  }

 private:
  static constexpr int kSpins = 4000;

  static void pause() {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }

  // In separate cache lines: arriving threads do not disturb waiting ones.
  alignas(64) std::atomic<int> arrived_ = 0;
  alignas(64) std::atomic<unsigned> generation_ = 0;
};

/// One of the threads that work on a task together.
struct Team {
  int rank;
  int size;
  SpinBarrier& gate;

  void barrier() const {
    if (size > 1) gate.wait(size);
  }

  /// This thread's part [begin, end) of [0, n); parts begin at multiples of `grain`.
  [[nodiscard]] int begin(int n, int grain = 1) const { return part(n, grain, rank); }
  [[nodiscard]] int end(int n, int grain = 1) const { return part(n, grain, rank + 1); }

 private:
  [[nodiscard]] int part(int n, int grain, int r) const {
    if (r == size) return n;
    const int n_grains = (n + grain - 1) / grain;
    return static_cast<int>(static_cast<long>(n_grains) * r / size) * grain;
  }
};

/// Calls body(team) on up to `n_threads` threads at once. `body` must not throw.
template <class Body>
void run_team(int n_threads, const Body& body) {
  SpinBarrier gate;
  const int n = openmp_threads(n_threads);
  if (n <= 1) {
    body(Team{0, 1, gate});
    return;
  }
#pragma omp parallel num_threads(n) default(none) shared(body, gate)
  body(Team{omp_get_thread_num(), omp_get_num_threads(), gate});
}

}  // namespace arap
