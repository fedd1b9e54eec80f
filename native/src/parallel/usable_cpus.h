// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>

namespace arap {

/// CPUs that this process may use: not those that an affinity, OMP_NUM_THREADS or the quota of a container takes away.
[[nodiscard]] int usable_cpus();

/// CPUs that a quota allows, rounded up; empty if it allows all.
/// @param cpu_max  what the file cpu.max of a control group says: microseconds of each period, and the period
[[nodiscard]] std::optional<int> cpus_of_quota(std::string_view cpu_max);

}  // namespace arap
