// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <tuple>

#include "ordering/multilevel_graph.h"

namespace arap {

/// Finds a light separator whose sides weigh at most 0.6 of all, on coarser graphs first, refined on the way back
/// [Karypis and Kumar 1998, "A fast and high quality multilevel scheme"]. Deterministic.
/// @param coarser  coarser graphs to start from, each made from the one before
[[nodiscard]] Separator find_separator(const Graph& graph, std::span<const Coarsening> coarser = {});

/// Entries that the separator's own columns have in a factor at the least, if both sides come before it: eliminating a
/// connected part of a side couples all vertices of the separator beside that part.
[[nodiscard]] std::int64_t least_entries(const Graph& graph, const Separator& separator);

/// Makes a separator lighter by moving single vertices out of it and their neighbours on the other side into it: always
/// the best move, for a while also moves that make it heavier. [Fiduccia and Mattheyses 1982; for separators Ashcraft
/// and Liu 1998]
/// @param max_passes  each moves every vertex at most once
void refine(const Graph& graph, Separator& separator, int max_passes);

/// What a separator should minimize, lexicographically: excess weight of the heavier side, weight of the separator,
/// difference of the sides.
using SeparatorCost = std::tuple<int, int, int>;

[[nodiscard]] SeparatorCost separator_cost(const Separator& separator);

}  // namespace arap
