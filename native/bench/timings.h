// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "arap/options.h"
#include "task_file.h"

namespace arap::bench {

/// The parts of one local/global iteration, in the middle of a run; medians of several.
struct StepTimes {
  double local_ms = 0;            ///< all rotations
  double global_ms = 0;           ///< right-hand side, residual, solve, new positions
  double solve_ms = 0;            ///< the two triangular solves, a part of global_ms
  std::int64_t factor_bytes = 0;  ///< size of the factor, which a solve reads twice; 0 if unknown
};

[[nodiscard]] StepTimes time_steps(const TaskFile& task, const Options& options);

/// Read bandwidth in GB/s (10^9 bytes): `threads` threads read their parts of a buffer of `n_bytes` repeatedly. The
/// best of several samples; small buffers are read from the caches.
[[nodiscard]] double read_bandwidth_gb_per_s(std::int64_t n_bytes, int threads);

}  // namespace arap::bench
