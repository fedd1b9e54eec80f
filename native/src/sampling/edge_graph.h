// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "arap/types.h"
#include "base/processor.h"
#include "sparse/sparse.h"

namespace arap {

/// Vertices of a mesh joined by straight edges, with their lengths. Shortest paths in it approximate distances along
/// the surface.
class EdgeGraph {
 public:
  struct Arc {
    int vertex;
    float length;
  };

  /// @param K      (n, n), stored whole: vertices are joined if the pattern couples them
  /// @param rest   (n, 3)
  /// @param links  further pairs of vertices to join, each once
  EdgeGraph(const SparseMatrix& K, const Positions& rest, int threads,
            const std::vector<std::pair<int, int>>& links = {});

  [[nodiscard]] int n_vertices() const { return static_cast<int>(offsets_.size()) - 1; }
  [[nodiscard]] std::span<const Arc> arcs(int vertex) const {
    return std::span(arcs_).subspan(offsets_[vertex], offsets_[vertex + 1] - offsets_[vertex]);
  }
  /// Starts to load arcs(vertex) into the cache.
  void prefetch_arcs(int vertex) const { prefetch(arcs_.data() + offsets_[vertex]); }

 private:
  std::vector<int> offsets_;
  std::vector<Arc> arcs_;
};

}  // namespace arap
