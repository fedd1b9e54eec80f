// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Kernel sources include this header: no inline functions of other headers here, see simd.h.

namespace arap {

/// Anchors and sides are carried in blocks of so many: one line of a cache in single precision.
inline constexpr int kWrapBlock = 16;

/// Numbers of a map, and of a motion that is a sum of maps: three rows of (D, t), and four more that fill the line.
inline constexpr int kMapNumbers = 16;

/// How the surface around anchors is measured, see wrap/anchor_maps.h. The last block is filled up with anchors without
/// neighbours.
struct AnchorsView {
  const int* vertices;     ///< (n_anchors,)
  const int* offsets;      ///< (n_anchors + 1,) in the next two
  const int* neighbours;   ///< numbers of vertices
  const float* gradients;  ///< (n_neighbours, 4), the last number is 0
  const float* frames;     ///< (n_blocks, 9, kWrapBlock): u, v and the place
};

/// A point's share of an anchor's map.
struct AnchorWeight {
  int anchor;
  float weight;
};

/// What keeps each point on its side of a triangle, see wrap/surface_sides.h. All but the last of `numbers` is in
/// lengths of the triangle's longest edge.
struct SidesView {
  const int* corners;    ///< (n_blocks, 3, kWrapBlock): numbers of vertices
  const float* numbers;  ///< (n_blocks, kSideNumbers, kWrapBlock)
};

/// Where the numbers of a side begin.
namespace side {
inline constexpr int kAB = 0;         ///< the edges from the first corner, at rest
inline constexpr int kAC = 3;         ///< here, too
inline constexpr int kPlace = 6;      ///< of the point at rest, from the first corner
inline constexpr int kInverse = 9;    ///< 00, 01 and 11 of the inverse of the products of AB and AC; 0: do not look
inline constexpr int kDistance = 12;  ///< of the point at rest from the plane; < 0: behind the triangle
inline constexpr int kStrength = 13;  ///< of what moves the point along the normal: from 1 near to the triangle to 0
inline constexpr int kPerEdge = 14;   ///< one over the longest edge
}  // namespace side
inline constexpr int kSideNumbers = 15;

struct WrapKernels {
  /// Finds the maps of the anchors in blocks [begin, end).
  /// @param displacements  (n_vertices, 4) in double; the last number is 0
  /// @param maps           (n_anchors, kMapNumbers), at lines of the cache
  void (*find_maps)(const AnchorsView& anchors, const double* displacements, float* maps, int begin, int end);

  /// How far the points [begin, end) move: the sums of their shares of the maps, at the points.
  /// @param offsets  (n_points + 1,) in the weights
  /// @param points   (n_points, 4); the last number is 1
  /// @param moves    (end - begin, 4) takes the result, the last number is 0; and 0 up to the end of the last block
  void (*move_points)(const int* offsets, const AnchorWeight* weights, const float* maps, const float* points,
                      float* moves, int begin, int end);

  /// Adds to the moves of the points [begin, end) what keeps them on their sides, at their distances.
  /// @param displacements  as above
  /// @param growth         of lengths along the surface, as usual; > 0
  /// @param moves          of whole blocks, as move_points() writes them
  /// @param begin          at a block
  void (*push_points)(const SidesView& sides, const double* displacements, float growth, float* moves, int begin,
                      int end);
};

}  // namespace arap
