// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "graph.h"
#include "graph_coarsening.h"

namespace arap {

/// Vertices on two sides without an edge between them, and those that keep them apart.
struct Separator {
  using Side = std::uint8_t;
  static constexpr Side kBetween = 2;

  std::vector<Side> side;        ///< of each vertex: 0, 1 or kBetween
  std::array<int, 3> weights{};  ///< of the sides and of what is between
};

/// A light separator with no side heavier than about 0.6 of all, found on coarser graphs and refined on the way back
/// [Karypis and Kumar 1998, "A fast and high quality multilevel scheme"]. The same each time for the same graph.
/// @param coarser  graphs to begin with, each of the one before it
[[nodiscard]] Separator find_separator(const Graph& graph, std::span<const Coarsening> coarser = {});

}  // namespace arap
