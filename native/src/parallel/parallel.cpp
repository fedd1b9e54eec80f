// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/parallel.h"

#include "parallel/usable_cpus.h"

#if defined(ARAP_OPENMP)
#include <omp.h>

#include <exception>
#include <mutex>
#include <thread>

#include "parallel/process_id.h"
#endif

namespace arap {

#if defined(ARAP_OPENMP)
namespace {

/// Whether the system can give the calling thread `n_threads - 1` more.
bool can_start(int n_threads) {
  std::mutex until_all_are_there;
  std::vector<std::thread> threads;
  bool are_there = true;
  {
    const std::scoped_lock lock(until_all_are_there);
    try {
      threads.reserve(n_threads - 1);
      while (static_cast<int>(threads.size()) < n_threads - 1)
        threads.emplace_back([&] { const std::scoped_lock wait(until_all_are_there); });
    } catch (const std::exception&) {
      are_there = false;
    }
  }
  for (std::thread& thread : threads) thread.join();
  return are_there;
}

/// A team of threads that OpenMP's runtime can make. If it cannot, it ends the process.
class Team {
 public:
  /// For the calling thread. One team is made at a time: what the system could give it, it can give only once.
  explicit Team(int n_threads) {
    static std::mutex one_at_a_time;
    // The runtime keeps the team of each calling thread, and ends the threads that a smaller team does not use.
    thread_local int n_last = 1;
    if (n_threads > n_last) {
      being_made_ = std::unique_lock(one_at_a_time);
      is_possible_ = can_start(n_threads);
    }
    if (is_possible_) n_last = n_threads;
  }

  [[nodiscard]] bool is_possible() const { return is_possible_; }

  /// All its threads are there. Call it in the calling thread.
  void is_made() {
    if (being_made_.owns_lock()) being_made_.unlock();
  }

 private:
  bool is_possible_ = true;
  std::unique_lock<std::mutex> being_made_;
};

/// Whether this process is the one that had the first region. The runtime keeps its threads between regions. A forked
/// child does not have them, and GCC's runtime would wait for them forever.
bool has_runtime() {
  static const ProcessId first = process_id();
  return process_id() == first;
}

}  // namespace
#endif

int choose_threads(int requested, int n_vertices) {
  if (requested > 0) return requested;
  // With fewer vertices a thread, sharing a pass costs as much as it saves.
  constexpr int kVerticesPerThread = 5000;
  return std::clamp(n_vertices / kVerticesPerThread, 1, usable_cpus());
}

void for_each_piece(int threads, int n_pieces, const std::function<void(int piece)>& body) {
  const int n_threads = std::clamp(n_pieces, 1, std::max(1, threads));
#if defined(ARAP_OPENMP)
  if (n_threads > 1 && has_runtime()) {
    if (Team team(n_threads); team.is_possible()) {
      FirstFailure failure;
#pragma omp parallel num_threads(n_threads)
      {
        // The runtime starts all threads before the caller's, the first, goes on.
        if (omp_get_thread_num() == 0) team.is_made();
#pragma omp for schedule(static)
        for (int piece = 0; piece < n_pieces; ++piece) failure.guard([&] { body(piece); });
      }
      failure.rethrow();
      return;
    }
  }
#endif
  Workers(n_threads).run(n_pieces, body);
}

}  // namespace arap
