// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace arap::bench {

/// GB/s (10^9 bytes) at which `threads` threads read a buffer of `n_bytes` again and again, each its own part: the
/// limit of anything that has to read as much. Best of several passes; small buffers are read from the caches.
[[nodiscard]] double read_bandwidth_gb_per_s(std::int64_t n_bytes, int threads);

}  // namespace arap::bench
