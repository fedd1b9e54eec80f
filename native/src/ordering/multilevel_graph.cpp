// SPDX-License-Identifier: GPL-3.0-or-later
#include "ordering/multilevel_graph.h"

#include <algorithm>
#include <utility>

namespace arap {

namespace {

constexpr int kNone = -1;

/// Vertices of low degree first: they have the least choice of partners. Within one degree shuffled in blocks, so that
/// memory is read nearly in sequence.
std::vector<int> visiting_order(const Graph& graph, std::minstd_rand& random) {
  constexpr int kMaxDegree = 32;
  const int n = graph.n_vertices();
  std::vector<int> begin(kMaxDegree + 2, 0);
  const auto bucket = [&](int v) { return std::min(graph.degree(v), kMaxDegree); };
  for (int v = 0; v < n; ++v) ++begin[bucket(v) + 1];
  for (int d = 0; d <= kMaxDegree; ++d) begin[d + 1] += begin[d];
  std::vector<int> order(n);
  constexpr int kBlock = 64;
  const auto offset = static_cast<int>(random() % kBlock);
  for (int block = 0; block < n; block += kBlock) {
    const int size = std::min(kBlock, n - block);
    // 37 is coprime to 64. The last block is not shuffled.
    for (int k = 0; k < size; ++k) {
      const int v = block + (size == kBlock ? (37 * k + offset) % kBlock : k);
      order[begin[bucket(v)]++] = v;
    }
  }
  return order;
}

/// The partner of each vertex, itself if it has none.
std::vector<int> match(const Graph& graph, int max_weight, std::minstd_rand& random) {
  const int n = graph.n_vertices();
  std::vector<int> partner(n, kNone);
  std::vector<int> waiting(n, kNone);  // for each vertex: a neighbour that found no free partner
  int waiting_alone = kNone;
  const auto join = [&](int a, int b) {
    partner[a] = b;
    partner[b] = a;
  };
  const auto wait_at = [&](int& place, int v) {
    if (place != kNone && partner[place] == place && graph.weights[place] + graph.weights[v] <= max_weight) {
      join(place, v);
      place = kNone;
    } else {
      partner[v] = v;
      place = v;
    }
  };
  for (const int v : visiting_order(graph, random)) {
    if (partner[v] != kNone) continue;
    int best = kNone;
    int best_weight = 0;
    int lightest = 0;
    for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e) {
      const int u = graph.neighbours[e];
      if (partner[u] != kNone && partner[u] != u) continue;
      if (graph.weights[v] + graph.weights[u] > max_weight) continue;
      const int weight = graph.edge_weights[e];
      if (weight < best_weight || (weight == best_weight && graph.weights[u] >= lightest)) continue;
      best = u;
      best_weight = weight;
      lightest = graph.weights[u];
    }
    if (best != kNone) {
      join(v, best);
    } else {
      wait_at(graph.degree(v) > 0 ? waiting[graph.neighbours[graph.offsets[v]]] : waiting_alone, v);
    }
  }
  return partner;
}

/// Levels of a hierarchy. Still coarser graphs are matched for each piece separately, so that they fit its shape.
constexpr int kLevels = 3;
constexpr int kHeaviest = 1 << kLevels;

constexpr int kOutside = -1;

/// The vertices of a graph that remain, their new numbers and weights.
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

/// The coarse vertices with a remaining fine vertex.
Remainder above(const Remainder& fine, const Coarsening& coarsening) {
  Remainder remainder;
  remainder.index.assign(coarsening.graph.n_vertices(), kOutside);
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

Coarsening coarsen(const Graph& graph, int max_weight, std::minstd_rand& random) {
  const int n = graph.n_vertices();
  const std::vector<int> partner = match(graph, max_weight, random);
  Coarsening result;
  result.coarse_of.resize(n);
  std::vector<int> first;  // fine vertex of each coarse one
  first.reserve(n);
  for (int v = 0; v < n; ++v) {
    if (partner[v] < v) {
      result.coarse_of[v] = result.coarse_of[partner[v]];
    } else {
      result.coarse_of[v] = static_cast<int>(first.size());
      first.push_back(v);
    }
  }
  Graph& coarse = result.graph;
  const auto n_coarse = static_cast<int>(first.size());
  coarse.offsets.reserve(n_coarse + 1);
  coarse.weights.resize(n_coarse);
  coarse.neighbours.resize(graph.neighbours.size());
  coarse.edge_weights.resize(graph.neighbours.size());
  std::vector<int> place(n_coarse, kNone);  // of the edge to each coarse vertex, from the present one
  int end = 0;
  for (int c = 0; c < n_coarse; ++c) {
    const int begin = end;
    const auto collect = [&](int v) {
      coarse.weights[c] += graph.weights[v];
      for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e) {
        const int u = result.coarse_of[graph.neighbours[e]];
        if (u == c) continue;
        if (place[u] < begin) {
          place[u] = end;
          coarse.neighbours[end] = u;
          coarse.edge_weights[end] = graph.edge_weights[e];
          ++end;
        } else {
          coarse.edge_weights[place[u]] += graph.edge_weights[e];
        }
      }
    };
    collect(first[c]);
    if (partner[first[c]] != first[c]) collect(partner[first[c]]);
    coarse.offsets.push_back(end);
  }
  coarse.neighbours.resize(end);
  coarse.edge_weights.resize(end);
  return result;
}

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
