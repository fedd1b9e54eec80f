// SPDX-License-Identifier: GPL-3.0-or-later
#include "timings.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <vector>

#include "process.h"

namespace arap::bench {

namespace {

// Independent sums: one chain of additions would take longer than reading.
constexpr std::int64_t kSums = 32;

std::uint64_t sum(const std::uint64_t* words, std::int64_t n) {
  std::array<std::uint64_t, kSums> sums = {};
  for (std::int64_t k = 0; k + kSums <= n; k += kSums)
    for (std::int64_t lane = 0; lane < kSums; ++lane) sums[lane] += words[k + lane];
  std::uint64_t total = 0;
  for (const std::uint64_t s : sums) total += s;
  return total;
}

}  // namespace

double read_bandwidth_gb_per_s(std::int64_t n_bytes, int threads) {
  constexpr int kSamples = 7;
  constexpr std::int64_t kBytesPerSample = 400'000'000;
  const std::int64_t n_words = std::max<std::int64_t>(n_bytes / 8, kSums * threads);
  const std::int64_t n_passes = std::max<std::int64_t>(2, kBytesPerSample / (8 * n_words));
  const std::vector<std::uint64_t> words(n_words, 1);
  std::atomic<std::uint64_t> sink = 0;  // keeps the compiler from removing the sums
  double best_ms = 1e300;
  for (int sample = 0; sample < kSamples; ++sample) {
    const Stopwatch watch;
#pragma omp parallel num_threads(threads)
    {
      const std::int64_t begin = n_words * omp_get_thread_num() / omp_get_num_threads();
      const std::int64_t end = n_words * (omp_get_thread_num() + 1) / omp_get_num_threads();
      for (std::int64_t pass = 0; pass < n_passes; ++pass)
        sink.fetch_add(sum(words.data() + begin, end - begin), std::memory_order_relaxed);
    }
    best_ms = std::min(best_ms, watch.ms());
  }
  return 8e-6 * static_cast<double>(n_words * n_passes) / best_ms;
}

}  // namespace arap::bench
