// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <random>
#include <vector>

#include "graph.h"

namespace arap {

struct Coarsening {
  Graph graph;
  std::vector<int> coarse_of;  ///< of each fine vertex
};

/// Joins vertices in pairs, those with the heaviest edge between them first: about half as many remain. A separator of
/// the result is one of the graph. [Karypis and Kumar 1998, section 3.1]
[[nodiscard]] Coarsening coarsen(const Graph& graph, int max_weight, std::minstd_rand& random);

}  // namespace arap
