// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Kernel sources include this header: no inline functions of other headers here, see simd.h.

namespace arap {

/// Vertices in the cubes of a lattice of quadratic B-splines.
struct EmbeddingView {
  const int* pieces;          ///< (n_vertices,) -1: in none
  const float* places;        ///< (n_vertices, 3) in the piece's cube, 0 to 1
  const int* control_points;  ///< (n_pieces, 27)
};

struct LatticeKernels {
  /// Writes sum_k phi_k c_k of the vertices from `begin` to `end` that are in a piece.
  /// @param control_points  (n_control_points, 4), the fourth component is ignored
  /// @param points          (n_vertices, 3)
  void (*embed)(const EmbeddingView& vertices, const double* control_points, double* points, int begin, int end);
};

}  // namespace arap
