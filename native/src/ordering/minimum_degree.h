// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bitset>
#include <vector>

namespace arap {

/// The sparse rows of a small graph.
constexpr int kMinimumDegreeSize = 256;
using SmallRow = std::bitset<kMinimumDegreeSize>;

/// Order of elimination of the first n vertices: always one that has the fewest neighbours, as elimination has left
/// them. The others stay, but are counted. [Tinney and Walker 1967]
///
/// @param rows  neighbours of the first n vertices; columns beyond n are the others
/// @param n     at most kMinimumDegreeSize
[[nodiscard]] std::vector<int> minimum_degree(std::vector<SmallRow> rows, int n);

}  // namespace arap
