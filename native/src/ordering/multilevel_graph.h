// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "ordering/graph.h"

namespace arap {

struct Coarsening {
  Graph graph;
  std::vector<int> coarse_of;  ///< of each fine vertex
};

/// Joins vertices in pairs, those with the heaviest edge between them first: about half as many remain. A separator of
/// the result is one of the graph. [Karypis and Kumar 1998, section 3.1]
[[nodiscard]] Coarsening coarsen(const Graph& graph, int max_weight, std::minstd_rand& random);

/// Vertices on two sides without an edge between them, and those that keep them apart.
struct Separator {
  using Side = std::uint8_t;
  static constexpr Side kBetween = 2;

  std::vector<Side> side;        ///< of each vertex: 0, 1 or kBetween
  std::array<int, 3> weights{};  ///< of the sides and of what is between
};

/// A graph and what it is made of when it is made coarser, again and again, a few times.
struct GraphHierarchy {
  Graph graph;
  std::vector<Coarsening> coarser;  ///< each of the graph before it
};

[[nodiscard]] GraphHierarchy make_hierarchy(Graph graph);

/// The vertices on one side of a separator, and the edges among them.
struct GraphSide {
  GraphHierarchy hierarchy;
  std::vector<int> vertices;  ///< of the whole, ascending
};

/// Both sides. Their coarser graphs are what is left of those of the whole, which costs a fraction of matching anew.
/// They may have edges that have nothing left under them; so a separator of one is still one of the finer graph.
/// @param least  a side of no more vertices is not cut again, and has no coarser graphs
[[nodiscard]] std::array<GraphSide, 2> divide(const GraphHierarchy& whole, const Separator& separator, int least);

}  // namespace arap
