// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "sampling/surface_distance.h"

namespace arap {

struct ChosenNodes {
  std::vector<int> vertices;  ///< of each node
  std::vector<double> areas;  ///< of the surface around each node, which no other one is nearer to
};

/// Chooses nodes greedily, in the order of the vertices, so that every vertex is nearer than r to one, and moves each
/// once towards the centre of the area around it, by less than .4 r: every vertex stays nearer than 1.4 r to a node.
/// @param rest     (n, 3)
/// @param areas    (n,) of the surface at each vertex
/// @param radius   r > 0
/// @param mirrors  vertex maps of the mesh's mirror symmetries, each its own inverse: nodes are symmetric then
/// @param group    (n,) or empty: nodes of one group do not count as near for another's vertices
[[nodiscard]] ChosenNodes choose_nodes(const SurfaceGraph& graph, const Positions& rest,
                                       const std::vector<double>& areas, double radius,
                                       const std::vector<std::vector<int>>& mirrors, const std::vector<int>& group);

}  // namespace arap
