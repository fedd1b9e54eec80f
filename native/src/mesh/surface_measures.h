// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "arap/mesh.h"

namespace arap {

/// Bounding box of the vertices in faces, or of all if there are no faces. Isolated vertices neither hide a symmetry
/// nor make the object larger.
[[nodiscard]] inline Eigen::AlignedBox3d surface_box(const PolygonMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.n_parts() == 0 || mesh.part_of_vertex()[v] >= 0) box.extend(mesh.positions().row(v).transpose());
  return box;
}

/// Twice the vector area of a face: along its normal, as long as twice the area of its projection along the normal.
/// @param positions  (n, 3)
[[nodiscard]] inline Eigen::RowVector3d twice_vector_area(const Positions& positions, std::span<const int> face) {
  using Row = Eigen::RowVector3d;
  const Row first = positions.row(face[0]);
  Row doubled = Row::Zero();
  for (size_t k = 1; k + 1 < face.size(); ++k)
    doubled += Row(positions.row(face[k]) - first).cross(Row(positions.row(face[k + 1]) - first));
  return doubled;
}

}  // namespace arap
