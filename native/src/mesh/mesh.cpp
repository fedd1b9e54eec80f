// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/mesh.h"

#include <cstdint>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "mesh/mesh_vertices.h"
#include "mesh/surface_measures.h"

namespace arap {

PolygonMesh::PolygonMesh(Positions positions, std::vector<int> corner_vertices, std::vector<int> face_sizes)
    : positions_(std::move(positions)), corner_vertices_(std::move(corner_vertices)) {
  if (positions_.rows() > kMostVertices || corner_vertices_.size() > kMostCorners)
    throw InvalidInput(text("the mesh has ", positions_.rows(), " vertices and ", corner_vertices_.size(),
                            " corners of faces, must have at most ", kMostVertices, " and ", kMostCorners,
                            "; pose a coarser one"));
  require_rest_positions(positions_);
  face_offsets_.reserve(face_sizes.size() + 1);
  face_offsets_.push_back(0);
  int64_t n_corners = 0;
  for (size_t f = 0; f < face_sizes.size(); ++f) {
    if (face_sizes[f] < 3) throw InvalidInput(text("face_sizes[", f, "] = ", face_sizes[f], ", must be >= 3"));
    n_corners += face_sizes[f];
    if (n_corners > static_cast<int64_t>(corner_vertices_.size())) break;
    face_offsets_.push_back(static_cast<int>(n_corners));
  }
  if (n_corners != static_cast<int64_t>(corner_vertices_.size()))
    throw InvalidInput(text("the faces have ", corner_vertices_.size(), " corners, but face_sizes adds up to ",
                            n_corners, n_corners > static_cast<int64_t>(corner_vertices_.size()) ? " or more" : ""));

  MeshPartFinder finder(n_vertices());
  for (int f = 0; f < n_faces(); ++f) {
    for (const int v : face(f))
      if (v < 0 || v >= n_vertices())
        throw InvalidInput(
            text("face ", f, " names vertex ", v, ", but the mesh has vertices 0 to ", n_vertices() - 1));
    finder.add(face(f));
  }
  MeshParts parts = std::move(finder).parts();
  part_of_vertex_ = std::move(parts.part_of_vertex);
  loose_vertices_ = std::move(parts.loose_vertices);
  n_parts_ = parts.n_parts;
}

double PolygonMesh::diagonal() const { return surface_box(*this).diagonal().norm(); }

}  // namespace arap
