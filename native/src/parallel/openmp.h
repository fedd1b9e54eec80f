// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace arap {

/// Threads for a parallel region of OpenMP: `wanted`, but 1 in the child of a process that has had regions here. The
/// runtime keeps its threads for the next region, and GCC's would wait for ever for those that a child has not got.
[[nodiscard]] int openmp_threads(int wanted);

}  // namespace arap
