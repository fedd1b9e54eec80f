// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <tuple>

#include "ordering/multilevel_graph.h"

namespace arap {

/// Makes a separator lighter by moving single vertices out of it, and what they touch on the other side in: the best
/// move first, also moves that make it heavier for a while. [Fiduccia and Mattheyses 1982; for separators Ashcraft and
/// Liu 1998]
/// @param max_passes  each takes every vertex at most once
void refine(const Graph& graph, Separator& separator, int max_passes);

/// What a search for separators minimizes, the first first: how much a side is too heavy, the weight between, the
/// difference of the sides.
using SeparatorCost = std::tuple<int, int, int>;

[[nodiscard]] SeparatorCost separator_cost(const Separator& separator);

}  // namespace arap
