// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "parallel/meter.h"
#include "sampling/edge_graph.h"

namespace arap {

struct DiskSamples {
  std::vector<int> vertices;  ///< of each sample
  std::vector<double> areas;  ///< of each sample's Voronoi cell: the surface that is nearest to it
};

/// Poisson-disk sampling of the vertices, then one Lloyd step. Takes vertices greedily in their order until every
/// vertex is nearer than r to a sample. Then moves each sample towards the centre of its Voronoi cell, by less than .4
/// r, so every vertex stays nearer than 1.4 r to a sample.
/// @param rest     (n, 3)
/// @param areas    (n,) surface area at each vertex
/// @param radius   r > 0
/// @param mirrors  vertex maps of the mesh's mirror symmetries, each its own inverse; makes the samples symmetric
/// @param group    (n,) or empty: a vertex only counts samples of its own group as near
[[nodiscard]] DiskSamples sample_poisson_disk(const EdgeGraph& graph, const Positions& rest,
                                              const std::vector<double>& areas, double radius,
                                              const std::vector<std::vector<int>>& mirrors,
                                              const std::vector<int>& group, const MeterPart& meter = {});

}  // namespace arap
