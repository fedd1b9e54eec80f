// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "arap/mesh.h"
#include "arap/options.h"

namespace arap {

/// A triangle of the surface. Edge k is opposite to corner k: it joins corners k + 1 and k + 2 (mod 3).
struct Triangle {
  std::array<int, 3> vertices;
  int face;                               ///< of the mesh
  std::array<double, 3> half_cotangents;  ///< 1/2 cot of the angle at corner k = weight of edge k, times the share of
                                          ///< the triangle in its face; may be negative
};

/// Replacement of a degenerate triangle: the energy k |u(p') - R u(p)|^2 with u(p) = sum of coefficients * positions. R
/// is the rotation of the cell of vertices[0]. The coefficients sum to 0, so translations cost nothing.
struct Tie {
  std::array<int, 3> vertices;
  int face;  ///< of the mesh
  std::array<double, 3> coefficients;
  double weight;
};

struct Triangulation {
  std::vector<Triangle> triangles;  ///< those of a face one after the other, in the order of the faces
  std::vector<Tie> ties;            ///< the same
};

/// Triangles of all faces. A face with n corners becomes the fans of triangles from each of its corners, with the share
/// 1/n: a quad becomes the two triangles of each diagonal at half weight. This does not depend on how corners are
/// numbered. If n * n > kMostFanTriangles only so many evenly spaced corners have a fan, but at least kFewestFans: the
/// cost stays linear, with few triangles a corner.
///
/// Uniform weights replace every cotangent by 1. With cotangents a triangle lower than kDegenerateHeight of its longest
/// edge becomes ties: its weights would be meaningless, but its corners must stay together.
[[nodiscard]] Triangulation triangulate(const PolygonMesh& mesh, EdgeWeights weights);

/// Calls add(vertex, q) with what a triangle adds to the rest vectors of its corners: sum over its edges jk at j of
/// cot (p_j - p_k), twice the divergence of the rest's gradients there.
template <class Add>
void add_rest_vectors(const Triangle& triangle, const Positions& rest, const Add& add) {
  for (size_t edge = 0; edge < 3; ++edge) {
    const int a = triangle.vertices[(edge + 1) % 3];
    const int b = triangle.vertices[(edge + 2) % 3];
    const Eigen::RowVector3d pull = 2 * triangle.half_cotangents[edge] * (rest.row(a) - rest.row(b));
    add(a, pull);
    add(b, -pull);
  }
}

/// The same of a tie.
template <class Add>
void add_rest_vectors(const Tie& tie, const Positions& rest, const Add& add) {
  Eigen::RowVector3d u = Eigen::RowVector3d::Zero();
  for (size_t k = 0; k < 3; ++k) u += tie.coefficients[k] * rest.row(tie.vertices[k]);
  for (size_t k = 0; k < 3; ++k) add(tie.vertices[k], 2 * tie.weight * tie.coefficients[k] * u);
}

inline constexpr size_t kMostFanTriangles = 2048;
inline constexpr size_t kFewestFans = 4;
inline constexpr double kDegenerateHeight = 1e-4;

/// 1/2 cot of the angle at each corner. The triangle must not be degenerate. [SA07] Sec. 2.2.
[[nodiscard]] std::array<double, 3> half_cotangents(const Vector3& a, const Vector3& b, const Vector3& c);

}  // namespace arap
