// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace arap {

/// Number of threads for an OpenMP region: `wanted`, but 1 in a forked child whose parent has had regions. The runtime
/// keeps its threads between regions, a child does not have them, and GCC's runtime would wait for them forever.
[[nodiscard]] int openmp_threads(int wanted);

}  // namespace arap
