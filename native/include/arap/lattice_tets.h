// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "arap/tet_mesh.h"
#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// Tetrahedra around a surface and what is inside it, for a TetArap to pose the surface by.
struct LatticeTets {
  TetMesh mesh;
  /// Of each vertex of the surface, the tetrahedron that it is in; -1: it is loose. (n,)
  std::vector<int> tet_of_vertex;
  /// Where it is in there: barycentric coordinates, >= 0, sum 1. (n,)
  std::vector<std::array<double, 4>> coordinates;

  /// The cubes of the lattice of LatticeArap, each cut into six tetrahedra. What is not connected within a cube has a
  /// copy of it each, as two fingers have, and cubes that hang together share corners. Cubes at the surface are whole.
  /// A closed part inside of another one and turned the other way is its void.
  /// @param cube_size  as LatticeOptions::cube_size
  /// Throws InvalidInput for a bad cube_size, too many cubes, or a mesh without faces or size; Cancelled when
  /// `progress` returns false.
  [[nodiscard]] static LatticeTets around(const PolygonMesh& surface, double cube_size = 0,
                                          const Progress& progress = {});

  /// The constraint that holds a vertex of the surface. Throws InvalidInput if that is loose or out of range.
  [[nodiscard]] Patch patch(int vertex) const;

  /// Moves the vertices of the surface with their tetrahedra; loose ones stay.
  /// @param of_tets     (mesh.n_vertices(), 3)
  /// @param of_surface  (n, 3)
  /// Throws InvalidInput for other numbers of rows.
  void embed(const Positions& of_tets, Positions& of_surface) const;
};

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
