// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"

namespace arap {

/// For each vertex one before it within `distance` > 0 of it along every axis that has none itself; itself where there
/// is none. Which, where there are several, depends on the positions alone.
[[nodiscard]] std::vector<int> coincident_with(const Positions& positions, double distance, int threads);

}  // namespace arap
