// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/parallel.h"

#if defined(ARAP_OPENMP)
#include <omp.h>

#include "parallel/process_id.h"
#else
#include <thread>
#endif

namespace arap {

namespace {

#if defined(ARAP_OPENMP)
/// Number of threads for an OpenMP region: `wanted`, but 1 in a forked child whose parent has had regions. The runtime
/// keeps its threads between regions, a child does not have them, and GCC's runtime would wait for them forever.
int openmp_threads(int wanted) {
  if (wanted <= 1) return 1;
  // The runtime's threads belong to the process that first had a region.
  static const ProcessId first = process_id();
  return process_id() == first ? wanted : 1;
}

int most_threads() { return omp_get_max_threads(); }
#else
int most_threads() { return static_cast<int>(std::thread::hardware_concurrency()); }
#endif

}  // namespace

int choose_threads(int requested, int n_vertices) {
  if (requested > 0) return requested;
  // With fewer vertices a thread, sharing a pass costs as much as it saves.
  constexpr int kVerticesPerThread = 5000;
  return std::clamp(n_vertices / kVerticesPerThread, 1, std::max(1, most_threads()));
}

void for_each_piece(int threads, int n_pieces, const std::function<void(int piece)>& body) {
#if defined(ARAP_OPENMP)
  const int n_threads = openmp_threads(std::min(threads, n_pieces));
  FirstFailure failure;
#pragma omp parallel for num_threads(n_threads) if (n_threads > 1) schedule(static)
  for (int piece = 0; piece < n_pieces; ++piece) failure.guard([&] { body(piece); });
  failure.rethrow();
#else
  Workers(std::clamp(n_pieces, 1, std::max(1, threads))).run(n_pieces, body);
#endif
}

}  // namespace arap
