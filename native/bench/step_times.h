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
  double solve_ms = 0;            ///< of it: the two triangular solves
  std::int64_t factor_bytes = 0;  ///< that a solve reads twice, on its ways there and back; 0 where nobody says
};

[[nodiscard]] StepTimes time_steps(const TaskFile& task, const Options& options);

}  // namespace arap::bench
