// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bitset>
#include <vector>

namespace arap {

/// Neighbours of a vertex of a small graph.
constexpr int kMinimumDegreeSize = 256;
using SmallRow = std::bitset<kMinimumDegreeSize>;

/// Minimum-degree ordering of the first n vertices: always eliminates one with the fewest neighbours at that time. The
/// other vertices are not eliminated but count as neighbours. [Tinney and Walker 1967]
///
/// @param rows  neighbours of the first n vertices; columns from n on are the other vertices
/// @param n     at most kMinimumDegreeSize
[[nodiscard]] std::vector<int> minimum_degree(std::vector<SmallRow> rows, int n);

}  // namespace arap
