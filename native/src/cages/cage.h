// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"
#include "kernels/cage_kernels.h"

namespace arap {

/// A closed cage at rest: centred at its box, of diagonal 1, cut into triangles whose fronts are outwards. A convex
/// quad is cut along both diagonals, each half counting half, so that symmetric cages carry symmetrically. A concave
/// one is cut along the diagonal inside.
class Cage {
 public:
  /// Throws InvalidInput: no faces or size, a face of more than four corners, not closed, faces of different sides,
  /// nothing enclosed.
  explicit Cage(const PolygonMesh& mesh);

  [[nodiscard]] int n_vertices() const { return n_vertices_; }
  [[nodiscard]] int n_triangles() const { return static_cast<int>(triangles_.size()); }
  [[nodiscard]] const std::vector<CageEdge>& edges() const { return edges_; }
  [[nodiscard]] const std::vector<CageTriangle>& triangles() const { return triangles_; }
  [[nodiscard]] const CageTriangle& triangle(int t) const { return triangles_[t]; }
  /// Of each triangle: equal for those that one cut makes of one face.
  [[nodiscard]] const std::vector<int>& cut_of_triangle() const { return cut_of_triangle_; }
  [[nodiscard]] const std::vector<int>& face_of_triangle() const { return face_of_triangle_; }
  /// (n, 3) in this space; of those in no face, too, which may be anywhere.
  [[nodiscard]] const Positions& vertices() const { return vertices_; }
  /// Sides of the box of vertices in faces, whose middle is 0.
  [[nodiscard]] const Eigen::RowVector3d& sides() const { return sides_; }

  /// For the kernels; valid as long as the cage.
  [[nodiscard]] CageView view() const;

  [[nodiscard]] double size() const { return size_; }
  [[nodiscard]] Eigen::RowVector3d to_cage(const Eigen::RowVector3d& point) const { return (point - center_) / size_; }

 private:
  class Builder;

  int n_vertices_ = 0;
  double size_ = 1;
  Eigen::RowVector3d center_;
  Eigen::RowVector3d sides_;
  Positions vertices_;
  std::vector<CageEdge> edges_;
  std::vector<CageTriangle> triangles_;
  std::vector<int> cut_of_triangle_;
  std::vector<int> face_of_triangle_;
};

/// What is linear in a point, of a triangle: see CageTriangle.
struct TrianglePlace {
  TrianglePlace(const CageTriangle& triangle, const Eigen::RowVector3d& point);

  /// The linear function that is 1 at a corner and 0 at the other two, at the foot of the point.
  [[nodiscard]] double hat(int corner) const { return heights[corner] * per_height[corner]; }
  /// Whether the point is on the triangle, as far as rounding tells.
  [[nodiscard]] bool is_on() const;

  double depth;
  double heights[3];         // NOLINT: as in CageTriangle
  const double* per_height;  ///< of the triangle
};

/// The integral over a triangle of its hats times a kernel has the form of all coordinates here: with the integrals
/// I_e along its edges and I over it, that of corner k is per_height[k] (heights[k] I + depth sum_e <m_k, m_e> I_e),
/// m the normals of the edges in the plane.
[[nodiscard]] double of_corner(const CageTriangle& triangle, const TrianglePlace& place, int corner, double of_area,
                               const double* of_edges);

}  // namespace arap
