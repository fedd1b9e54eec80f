// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "constraints/prepared_constraints.h"
#include "parallel/meter.h"
#include "parallel/workers.h"
#include "sampling/edge_graph.h"

namespace arap {

/// A constrained vertex, and its row in the targets.
struct HandleVertex {
  int vertex;
  int row;
};

/// The constrained vertices of each handle.
using HandleVertices = std::vector<std::vector<HandleVertex>>;

/// How much of what each handle has a vertex takes.
class HandleWeights {
 public:
  HandleWeights() = default;
  /// Throws NotEnoughMemory.
  HandleWeights(int n_vertices, int n_handles);

  [[nodiscard]] bool empty() const { return n_handles_ == 0; }

  /// @param row  of the targets, which has what the handle has
  void set(int vertex, int handle, double weight, int row) {
    const size_t entry = static_cast<size_t>(vertex) * n_handles_ + handle;
    weights_[entry] = weight;
    rows_[entry] = row;
  }
  /// Makes the weights of each vertex that has any sum to 1.
  void normalize();

  /// @param of_rows  (n_targets, 3)
  /// @return         (n, 3)
  [[nodiscard]] Positions blend(const Positions& of_rows, const Workers& workers) const;

 private:
  int n_ = 0;
  int n_handles_ = 0;
  std::vector<double> weights_;  ///< (n, n_handles)
  std::vector<int> rows_;        ///< (n, n_handles)
};

/// Weights 1 / d_h, scaled to sum 1, with d_h the distance along edges to the nearest vertex of handle h; its row is
/// the one that counts, should those of a handle differ. Between two handles this falls off evenly. Vertices that no
/// handle reaches have weights 0.
[[nodiscard]] HandleWeights find_geodesic_weights(const EdgeGraph& graph, const HandleVertices& handles, int threads,
                                                  const MeterPart& meter);

/// Harmonic functions that are 1 on a handle and 0 on the others. The first row of a handle counts for all.
/// @param handle_of_row  (n_targets,)
/// @param accuracy       absolute
[[nodiscard]] HandleWeights find_harmonic_weights(const PreparedModel& model, const PreparedConstraints& constraints,
                                                  const std::vector<int>& handle_of_row, int n_handles,
                                                  double accuracy);

}  // namespace arap
