// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "ordering/multilevel_graph.h"

namespace arap {

/// A light separator with no side heavier than about 0.6 of all, found on coarser graphs and refined on the way back
/// [Karypis and Kumar 1998, "A fast and high quality multilevel scheme"]. The same each time for the same graph.
/// @param coarser  graphs to begin with, each of the one before it
[[nodiscard]] Separator find_separator(const Graph& graph, std::span<const Coarsening> coarser = {});

}  // namespace arap
