// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace arap::bench {

/// Read bandwidth in GB/s (10^9 bytes): `threads` threads read their parts of a buffer of `n_bytes` repeatedly. The
/// best of several samples; small buffers are read from the caches.
[[nodiscard]] double read_bandwidth_gb_per_s(std::int64_t n_bytes, int threads);

}  // namespace arap::bench
