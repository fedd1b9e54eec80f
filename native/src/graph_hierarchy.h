// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "graph.h"
#include "graph_coarsening.h"
#include "separator.h"

namespace arap {

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
