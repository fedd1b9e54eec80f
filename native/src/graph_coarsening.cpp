// SPDX-License-Identifier: GPL-3.0-or-later
#include "graph_coarsening.h"

#include <algorithm>

namespace arap {

namespace {

constexpr int kNone = -1;

/// Vertices of low degree first, as they have the least choice; among those of one degree in an order that is random
/// from block to block only, so that memory is read nearly in order.
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
    // 37 has no common factor with 64; the last block is taken in order.
    for (int k = 0; k < size; ++k) {
      const int v = block + (size == kBlock ? (37 * k + offset) % kBlock : k);
      order[begin[bucket(v)]++] = v;
    }
  }
  return order;
}

/// Each vertex' partner, itself where it has none.
std::vector<int> match(const Graph& graph, int max_weight, std::minstd_rand& random) {
  const int n = graph.n_vertices();
  std::vector<int> partner(n, kNone);
  std::vector<int> waiting(n, kNone);  // beside each vertex: a vertex that found all its neighbours taken
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

}  // namespace arap
