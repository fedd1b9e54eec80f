// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/parallel.h"

#include "parallel/usable_cpus.h"

#if defined(ARAP_OPENMP)
#include <exception>
#include <mutex>
#include <thread>

#include "parallel/process_id.h"
#endif

namespace arap {

#if defined(ARAP_OPENMP)
namespace {

/// Whether the system can give the calling thread `n_threads - 1` more. OpenMP's runtime would end the process if not.
bool can_have_team(int n_threads) {
  // The runtime keeps the team of each calling thread, and ends the threads that a smaller team does not use.
  thread_local int n_last = 1;
  if (n_threads <= n_last) {
    n_last = n_threads;
    return true;
  }
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
  if (are_there) n_last = n_threads;
  return are_there;
}

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
  if (n_threads > 1 && has_runtime() && can_have_team(n_threads)) {
    FirstFailure failure;
#pragma omp parallel for num_threads(n_threads) schedule(static)
    for (int piece = 0; piece < n_pieces; ++piece) failure.guard([&] { body(piece); });
    failure.rethrow();
    return;
  }
#endif
  Workers(n_threads).run(n_pieces, body);
}

}  // namespace arap
