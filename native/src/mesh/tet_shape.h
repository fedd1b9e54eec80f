// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/tet_mesh.h"
#include "arap/types.h"

namespace arap {

/// Edges of a tetrahedron from its first vertex, as columns: their determinant is six times its volume.
/// @param positions  (n, 3)
[[nodiscard]] inline Matrix3 tet_edges(const Positions& positions, const TetMesh::Tet& tet) {
  Matrix3 edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = (positions.row(tet[k + 1]) - positions.row(tet[0])).transpose();
  return edges;
}

}  // namespace arap
