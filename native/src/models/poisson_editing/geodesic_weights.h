// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "parallel/meter.h"
#include "parallel/workers.h"
#include "sampling/edge_graph.h"

namespace arap {

/// A constrained vertex, and its row in the targets.
struct HandleVertex {
  int vertex;
  int row;
};

/// How what handles have spreads along edges: a vertex has their mean with weights 1 / d_h, d_h the distance to the
/// nearest vertex of handle h. Of that one it takes what the handle has, should its vertices differ. Between two handles
/// this falls off evenly.
class GeodesicWeights {
 public:
  GeodesicWeights() = default;
  /// @param handles  the vertices of each
  GeodesicWeights(const EdgeGraph& graph, const std::vector<std::vector<HandleVertex>>& handles, int threads,
                  const MeterPart& meter);

  /// Vertices that no handle reaches get 0.
  /// @param of_rows  (n_targets, 3)
  /// @return         (n, 3)
  [[nodiscard]] Positions blend(const Positions& of_rows, const Workers& workers) const;

 private:
  int n_ = 0;
  int n_handles_ = 0;
  std::vector<double> weights_;  ///< (n, n_handles), sums 1 or 0
  std::vector<int> rows_;        ///< (n, n_handles) of the nearest vertex of a handle
};

}  // namespace arap
