// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "arap/error.h"
#include "arap/mesh.h"

namespace arap {

/// Bounding box of the vertices that are in a part, or of all if none is. Isolated vertices neither hide a symmetry nor
/// make the object larger.
[[nodiscard]] inline Eigen::AlignedBox3d box_of_parts(const Positions& positions,
                                                      const std::vector<int>& part_of_vertex) {
  const bool has_parts = std::any_of(part_of_vertex.begin(), part_of_vertex.end(), [](int part) { return part >= 0; });
  Eigen::AlignedBox3d box;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    if (!has_parts || part_of_vertex[v] >= 0) box.extend(positions.row(v).transpose());
  return box;
}

[[nodiscard]] inline Eigen::AlignedBox3d surface_box(const PolygonMesh& mesh) {
  return box_of_parts(mesh.positions(), mesh.part_of_vertex());
}

/// The vertices that are in faces, ascending.
[[nodiscard]] inline std::vector<int> vertices_in_faces(const PolygonMesh& mesh) {
  std::vector<int> result;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.part_of_vertex()[v] >= 0) result.push_back(v);
  return result;
}

/// Throws InvalidInput for a mesh that is nowhere.
/// @param what  it is, for the message
inline void require_surface(const PolygonMesh& mesh, const std::string& what = "the mesh") {
  if (mesh.n_faces() == 0 || !(mesh.diagonal() > 0))
    throw InvalidInput(what + " has no faces or no size; give it faces");
}

/// Calls visit(i, j, k) with the corners of each triangle of the fan from the first corner of a face.
template <class Visit>
void for_each_in_fan(std::span<const int> face, const Visit& visit) {
  for (size_t k = 1; k + 1 < face.size(); ++k) visit(face[0], face[k], face[k + 1]);
}

/// Twice the vector area of a face: along its normal, as long as twice the area of its projection along the normal.
/// @param positions  (n, 3)
[[nodiscard]] inline Eigen::RowVector3d twice_vector_area(const Positions& positions, std::span<const int> face) {
  const Eigen::RowVector3d first = positions.row(face[0]);
  Eigen::RowVector3d doubled = Eigen::RowVector3d::Zero();
  for_each_in_fan(face, [&](int, int j, int k) {
    doubled += Eigen::RowVector3d(positions.row(j) - first).cross(Eigen::RowVector3d(positions.row(k) - first));
  });
  return doubled;
}

}  // namespace arap
