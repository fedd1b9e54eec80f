// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Kernel sources include this header: no inline functions of other headers here, see simd.h.

namespace arap {

/// Anchors are carried in blocks of so many: one line of a cache in single precision.
inline constexpr int kAnchorBlock = 16;

/// Numbers of a map, and of a motion that is a sum of maps: three rows of (D, t), and four more that fill the line.
inline constexpr int kMapNumbers = 16;

/// How the surface around anchors is measured, see wrap/anchor_maps.h. The last block is filled up with anchors without
/// neighbours.
struct AnchorsView {
  const int* vertices;     ///< (n_anchors,)
  const int* offsets;      ///< (n_anchors + 1,) in the next two
  const int* neighbours;   ///< numbers of vertices
  const float* gradients;  ///< (n_neighbours, 4), the last number is 0
  const float* frames;     ///< (n_blocks, 9, kAnchorBlock): u, v and the place
};

/// A point's share of an anchor's map.
struct AnchorWeight {
  int anchor;
  float weight;
};

struct WrapKernels {
  /// Finds the maps of the anchors in blocks [begin, end).
  /// @param displacements  (n_vertices, 4) in double; the last number is 0
  /// @param maps           (n_anchors, kMapNumbers), at lines of the cache
  void (*find_maps)(const AnchorsView& anchors, const double* displacements, float* maps, int begin, int end);

  /// How far the points [begin, end) move: the sums of their shares of the maps, at the points.
  /// @param offsets  (n_points + 1,) in the weights
  /// @param points   (n_points, 4); the last number is 1
  /// @param moves    (end - begin, 4) takes the result; the last number means nothing
  void (*move_points)(const int* offsets, const AnchorWeight* weights, const float* maps, const float* points,
                      float* moves, int begin, int end);
};

}  // namespace arap
