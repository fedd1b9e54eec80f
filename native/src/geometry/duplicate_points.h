// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "parallel/meter.h"

namespace arap {

/// Maps each vertex to an earlier vertex that coincides with it (at most `distance` away along every axis) and maps to
/// itself; to itself if there is none. Which one of several depends on the positions alone.
[[nodiscard]] std::vector<int> coincident_with(const Positions& positions, double distance, int threads,
                                               const MeterPart& meter = {});

}  // namespace arap
