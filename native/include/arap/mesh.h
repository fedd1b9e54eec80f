// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// A validated polygon mesh. Faces may be triangles, quads or n-gons, convex or not, non-manifold, flipped, duplicate
/// or degenerate: what a face cannot give is left out, never refused.
class PolygonMesh {
 public:
  /// @param positions        (n, 3) rest positions, finite
  /// @param corner_vertices  the faces' vertices, one face after the other
  /// @param face_sizes       number of consecutive entries of each face, >= 3
  /// Throws InvalidInput that names the vertex or the face.
  PolygonMesh(Positions positions, std::vector<int> corner_vertices, std::vector<int> face_sizes);

  [[nodiscard]] int n_vertices() const { return static_cast<int>(positions_.rows()); }
  [[nodiscard]] int n_faces() const { return static_cast<int>(face_offsets_.size()) - 1; }
  /// Of all faces.
  [[nodiscard]] int n_corners() const { return face_offsets_.back(); }
  [[nodiscard]] const Positions& positions() const { return positions_; }
  [[nodiscard]] std::span<const int> face(int f) const {
    return std::span<const int>(corner_vertices_).subspan(face_offsets_[f], face_offsets_[f + 1] - face_offsets_[f]);
  }

  /// Connected part of each vertex, (n,), numbered by lowest vertex; -1 for loose vertices (in no face).
  [[nodiscard]] const std::vector<int>& part_of_vertex() const { return part_of_vertex_; }
  [[nodiscard]] int n_parts() const { return n_parts_; }
  [[nodiscard]] const std::vector<int>& loose_vertices() const { return loose_vertices_; }

  /// Length of the diagonal of the bounding box of vertices in faces, of all where there are no faces: what settings
  /// call the bounding-box diagonal. 0 where they are at one place.
  [[nodiscard]] double diagonal() const;

  /// For each vertex the first one at its place, (n,), its own number if it is that one. Along each axis it may differ
  /// by 1e-6 of the diagonal, or by what rounds so far from the origin: single precision, if all coordinates are that.
  /// Throws Cancelled when `progress` returns false.
  [[nodiscard]] std::vector<int> same_places(int threads = 1, const Progress& progress = {}) const;
  /// How many parts there are if vertices at the same place are joined. Fewer than n_parts(): the mesh has open seams,
  /// as many files have along those of a texture, and a pose tears it there.
  [[nodiscard]] int n_parts_joined(int threads = 1) const;

 private:
  Positions positions_;
  std::vector<int> corner_vertices_;
  std::vector<int> face_offsets_;
  std::vector<int> part_of_vertex_;
  std::vector<int> loose_vertices_;
  int n_parts_ = 0;
};

}  // namespace ARAP_COMPILED_ALIKE

}  // namespace arap
