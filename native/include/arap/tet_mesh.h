// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// A validated mesh of tetrahedra. They need not fill a region or meet in whole faces; each may be turned inside out.
class TetMesh {
 public:
  using Tet = std::array<int, 4>;

  /// @param positions  (n, 3) rest positions, finite
  /// @param tets       the vertices of each tetrahedron, four different ones that are not in one plane. Of those with
  ///                   negative volume the last two vertices are swapped
  /// Throws InvalidInput that names the vertex or the tetrahedron.
  TetMesh(Positions positions, std::vector<Tet> tets);

  [[nodiscard]] int n_vertices() const { return static_cast<int>(positions_.rows()); }
  [[nodiscard]] int n_tets() const { return static_cast<int>(tets_.size()); }
  [[nodiscard]] const Positions& positions() const { return positions_; }
  /// All of positive volume.
  [[nodiscard]] const std::vector<Tet>& tets() const { return tets_; }

  /// Connected part of each vertex, (n,), numbered by lowest vertex; -1 for loose vertices (in no tetrahedron).
  [[nodiscard]] const std::vector<int>& part_of_vertex() const { return part_of_vertex_; }
  [[nodiscard]] int n_parts() const { return n_parts_; }
  [[nodiscard]] const std::vector<int>& loose_vertices() const { return loose_vertices_; }
  /// As PolygonMesh::n_parts_joined().
  [[nodiscard]] int n_parts_joined(int threads = 1) const;

  /// Length of the diagonal of the bounding box of vertices in tetrahedra, of all where there are none.
  [[nodiscard]] double diagonal() const;

 private:
  Positions positions_;
  std::vector<Tet> tets_;
  std::vector<int> part_of_vertex_;
  std::vector<int> loose_vertices_;
  int n_parts_ = 0;
};

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
