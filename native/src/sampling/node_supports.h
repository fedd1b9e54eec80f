// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "parallel/meter.h"
#include "sampling/edge_graph.h"

namespace arap {

/// A vertex within a distance.
struct Reached {
  int vertex;
  float distance;
};

/// Most nodes that a vertex may use. On a surface some ten are within the support, with an opposite wall twice as many.
/// Without a limit a thousand nodes about one vertex, each at a face of its own, would make a million entries.
inline constexpr int kMostNodes = 32;

/// For each node the vertices nearer than `support` along the graph, of a vertex with more than kMostNodes nodes only
/// those to which it is among the nearest. In no particular order, but always in the same.
/// @param nodes    vertices, each once
/// @param support  at most
[[nodiscard]] std::vector<std::vector<Reached>> find_supports(const EdgeGraph& graph, const std::vector<int>& nodes,
                                                              float support, int threads, const MeterPart& meter = {});

}  // namespace arap
