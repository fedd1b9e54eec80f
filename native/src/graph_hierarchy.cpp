// SPDX-License-Identifier: GPL-3.0-or-later
#include "graph_hierarchy.h"

#include <random>
#include <utility>

namespace arap {

namespace {

/// The vertices of a coarser graph weigh eight at most: coarser ones are matched anew for each part, so that they have
/// its shape.
constexpr int kLevels = 3;
constexpr int kHeaviest = 1 << kLevels;

constexpr int kOutside = -1;

/// Which vertices of a graph remain, how they are numbered, and what is left of their weights.
struct Remainder {
  std::vector<int> vertices;  ///< ascending
  std::vector<int> index;     ///< of each vertex of the graph, or kOutside
  std::vector<int> weights;   ///< of each that remains
};

Remainder on_side(const Graph& graph, const Separator& separator, int side) {
  Remainder remainder;
  remainder.index.assign(graph.n_vertices(), kOutside);
  for (int v = 0; v < graph.n_vertices(); ++v) {
    if (separator.side[v] != side) continue;
    remainder.index[v] = static_cast<int>(remainder.vertices.size());
    remainder.vertices.push_back(v);
    remainder.weights.push_back(graph.weights[v]);
  }
  return remainder;
}

/// The coarse vertices that have something left.
Remainder above(const Remainder& fine, const Coarsening& coarsening) {
  Remainder remainder;
  remainder.index.assign(coarsening.graph.n_vertices(), kOutside);
  // The fine vertices come in the order of the first ones of the coarse ones: so do these, nearly.
  for (size_t k = 0; k < fine.vertices.size(); ++k) {
    const int c = coarsening.coarse_of[fine.vertices[k]];
    if (remainder.index[c] == kOutside) {
      remainder.index[c] = static_cast<int>(remainder.vertices.size());
      remainder.vertices.push_back(c);
      remainder.weights.push_back(0);
    }
    remainder.weights[remainder.index[c]] += fine.weights[k];
  }
  return remainder;
}

Graph restricted(const Graph& whole, const Remainder& remainder) {
  size_t n_neighbours = 0;
  for (const int v : remainder.vertices) n_neighbours += whole.degree(v);
  Graph graph;
  graph.offsets.reserve(remainder.vertices.size() + 1);
  graph.neighbours.reserve(n_neighbours);
  graph.edge_weights.reserve(n_neighbours);
  for (const int v : remainder.vertices) {
    for (int e = whole.offsets[v]; e < whole.offsets[v + 1]; ++e) {
      const int u = remainder.index[whole.neighbours[e]];
      if (u == kOutside) continue;
      graph.neighbours.push_back(u);
      graph.edge_weights.push_back(whole.edge_weights[e]);
    }
    graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
  }
  graph.weights = remainder.weights;
  return graph;
}

GraphSide make_side(const GraphHierarchy& whole, const Separator& separator, int side, int least) {
  Remainder remainder = on_side(whole.graph, separator, side);
  GraphSide result;
  result.hierarchy.graph = restricted(whole.graph, remainder);
  result.vertices = remainder.vertices;
  if (std::ssize(result.vertices) <= least) return result;
  for (const Coarsening& coarsening : whole.coarser) {
    Remainder coarse = above(remainder, coarsening);
    Coarsening left;
    left.graph = restricted(coarsening.graph, coarse);
    left.coarse_of.reserve(remainder.vertices.size());
    for (const int v : remainder.vertices) left.coarse_of.push_back(coarse.index[coarsening.coarse_of[v]]);
    result.hierarchy.coarser.push_back(std::move(left));
    remainder = std::move(coarse);
  }
  return result;
}

}  // namespace

GraphHierarchy make_hierarchy(Graph graph) {
  GraphHierarchy hierarchy{.graph = std::move(graph), .coarser = {}};
  std::minstd_rand random;
  const Graph* finest = &hierarchy.graph;
  hierarchy.coarser.reserve(kLevels);
  for (int level = 0; level < kLevels; ++level) {
    hierarchy.coarser.push_back(coarsen(*finest, kHeaviest, random));
    finest = &hierarchy.coarser.back().graph;
  }
  return hierarchy;
}

std::array<GraphSide, 2> divide(const GraphHierarchy& whole, const Separator& separator, int least) {
  return {make_side(whole, separator, 0, least), make_side(whole, separator, 1, least)};
}

}  // namespace arap
