// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <numeric>
#include <vector>

namespace arap {

/// An undirected graph without loops. Each edge is stored at both ends.
struct Graph {
  std::vector<int> offsets{0};  ///< (n + 1,) of each vertex in neighbours
  std::vector<int> neighbours;
  std::vector<int> edge_weights;  ///< of each entry of neighbours
  std::vector<int> weights;       ///< of vertices

  [[nodiscard]] int n_vertices() const { return static_cast<int>(offsets.size()) - 1; }
  [[nodiscard]] int degree(int v) const { return offsets[v + 1] - offsets[v]; }
  [[nodiscard]] int total_weight() const { return std::reduce(weights.begin(), weights.end()); }

  /// Gives every vertex and every edge the weight 1.
  void weigh_alike() {
    weights.assign(n_vertices(), 1);
    edge_weights.assign(neighbours.size(), 1);
  }
};

}  // namespace arap
