// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Kernel sources include this header: no inline functions of other headers here, see simd.h.

namespace arap {

/// Points are carried in blocks of so many: one line of a cache in single precision.
inline constexpr int kCageBlock = 16;

/// Points farther than this from the middle of a cage of diagonal 1 are far: there its triangles are seen alike.
inline constexpr double kFarFromCage = 30;

/// An edge of the triangles of a cage, in either direction.
struct CageEdge {
  double start[3];  // NOLINT: no std::array here, see simd.h
  double along[3];  // NOLINT: to its end
  double length;
  int ends[2];  // NOLINT: its vertices, start first
};

/// A triangle of a cage, with its front outwards. Edge k is opposite to corner k.
struct CageTriangle {
  int vertices[3];       // NOLINT
  int edges[3];          // NOLINT
  double depth[4];       // NOLINT: d(x) = depth . (x, 1), the distance from x to the plane; > 0 behind it
  double heights[3][4];  // NOLINT: h_k(x) = heights[k] . (x, 1), from the line of edge k inwards, in the plane
  double per_height[3];  // NOLINT: h_k(x) per_height[k] is 1 at corner k and 0 at the others
  double cosines[3];     // NOLINT: between the edges' normals: of edges 1 and 2, 2 and 0, 0 and 1
  double share;          ///< of its face: a half, if that is cut along both diagonals
  double twice_area;
};

/// A cage of diagonal 1.
struct CageView {
  const CageEdge* edges;
  const CageTriangle* triangles;
  const double* vertices;  ///< (n_vertices, 3)
  int n_vertices;
  int n_edges;
  int n_triangles;
};

/// Both compute the weights of a block of points.
struct CageKernels {
  /// Mean value coordinates, see cages/mean_value.h.
  /// @param points   (3, kCageBlock)
  /// @param scratch  (2 n_edges + 2 n_vertices, kCageBlock)
  /// @param weights  (n_vertices, kCageBlock), takes the result
  /// @return  bit k: point k is so near to the plane of a triangle, or so far away, that rounding is seen
  unsigned (*mean_values)(const CageView& cage, const double* points, double* scratch, float* weights);

  /// Green coordinates, see cages/green.h.
  /// @param weights  (n_vertices + n_triangles, kCageBlock), takes the result
  /// @return  bit k: point k may be on the cage or outside
  unsigned (*green)(const CageView& cage, const double* points, double* scratch, float* weights);

  /// Sums weights times motions, in double.
  /// @param weights  (n_rows, kCageBlock)
  /// @param motions  (n_rows, 3)
  /// @param sums     (3, kCageBlock), takes the result
  void (*carry)(const float* weights, const double* motions, int n_rows, double* sums);
};

}  // namespace arap
