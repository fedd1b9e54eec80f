// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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
};

}  // namespace arap
