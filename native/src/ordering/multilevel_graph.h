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

/// Heavy-edge matching: joins pairs of vertices with heavy edges between them, so that about half as many remain. A
/// separator of the result is a separator of the graph. [Karypis and Kumar 1998, section 3.1]
[[nodiscard]] Coarsening coarsen(const Graph& graph, int max_weight, std::minstd_rand& random);

/// Two sets of vertices without an edge between them, and the vertices that separate them.
struct Separator {
  using Side = std::uint8_t;
  static constexpr Side kBetween = 2;

  std::vector<Side> side;        ///< of each vertex: 0, 1 or kBetween
  std::array<int, 3> weights{};  ///< of side 0, side 1 and the separator
};

/// A graph and a few coarser ones, each made from the one before.
struct GraphHierarchy {
  Graph graph;
  std::vector<Coarsening> coarser;  ///< each of the graph before
};

[[nodiscard]] GraphHierarchy make_hierarchy(Graph graph);

/// The vertices on one side of a separator, and the edges among them.
struct GraphSide {
  GraphHierarchy hierarchy;
  std::vector<int> vertices;  ///< of the whole, ascending
};

/// Both sides. Their coarser graphs are restrictions of the coarser graphs of the whole, which is much faster than a
/// new matching. They may have edges without a fine edge, so their separators are still separators of the finer graph.
/// @param least  a side of at most this many vertices gets no coarser graphs
[[nodiscard]] std::array<GraphSide, 2> divide(const GraphHierarchy& whole, const Separator& separator, int least);

}  // namespace arap
