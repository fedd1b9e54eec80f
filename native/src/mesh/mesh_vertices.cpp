// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh_vertices.h"

#include "arap/error.h"
#include "base/format_message.h"

namespace arap {

void require_rest_positions(const Positions& positions) {
  if (positions.rows() == 0) throw InvalidInput("rest_positions is empty; the mesh needs at least one vertex");
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    const auto row = positions.row(v);
    if (is_within_range(row)) continue;
    throw InvalidInput(text("rest_positions: vertex ", v, " is at (", row[0], ", ", row[1], ", ", row[2],
                            "), must be finite and below 1e100; repair or remove the vertex"));
  }
}

void MeshPartFinder::add(std::span<const int> corners) {
  for (const int v : corners) {
    has_vertex_[v] = 1;
    sets_.join(corners.front(), v);
  }
}

MeshParts MeshPartFinder::parts() && {
  MeshParts parts;
  parts.part_of_vertex.assign(has_vertex_.size(), -1);
  for (int v = 0; v < sets_.size(); ++v) {
    if (has_vertex_[v] == 0) {
      parts.loose_vertices.push_back(v);
      continue;
    }
    const int root = sets_.find(v);
    parts.part_of_vertex[v] = root == v ? parts.n_parts++ : parts.part_of_vertex[root];
  }
  return parts;
}

}  // namespace arap
