// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <numeric>
#include <vector>

namespace arap {

/// An undirected graph without loops; each edge is stored at both ends.
struct Graph {
  std::vector<int> offsets{0};  ///< of each vertex in neighbours; one more at the end
  std::vector<int> neighbours;
  std::vector<int> edge_weights;  ///< as neighbours
  std::vector<int> weights;       ///< of vertices

  [[nodiscard]] int n_vertices() const { return static_cast<int>(offsets.size()) - 1; }
  [[nodiscard]] int degree(int v) const { return offsets[v + 1] - offsets[v]; }
  /// Of all vertices.
  [[nodiscard]] int total_weight() const { return std::reduce(weights.begin(), weights.end()); }

  /// Every vertex and every edge weighs 1.
  void weigh_alike() {
    weights.assign(n_vertices(), 1);
    edge_weights.assign(neighbours.size(), 1);
  }
};

}  // namespace arap
