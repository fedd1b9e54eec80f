// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"

namespace arap {

/// For each vertex the first vertex within `distance` > 0 of it along every axis, itself where there is none before it.
[[nodiscard]] std::vector<int> coincident_with(const Positions& positions, double distance, int threads);

}  // namespace arap
