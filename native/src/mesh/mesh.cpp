// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "base/union_find.h"
#include "mesh/surface_measures.h"

namespace arap {

namespace {

void require_finite_positions(const Positions& positions) {
  // Squares of larger lengths overflow.
  constexpr double kLargest = 1e100;
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    const auto row = positions.row(v);
    if (row.allFinite() && row.cwiseAbs().maxCoeff() <= kLargest) continue;
    throw InvalidInput(text("rest_positions: vertex ", v, " is at (", row[0], ", ", row[1], ", ", row[2],
                            "), must be finite and below 1e100; repair or remove the vertex"));
  }
}

}  // namespace

PolygonMesh::PolygonMesh(Positions positions, std::vector<int> corner_vertices, std::vector<int> face_sizes)
    : positions_(std::move(positions)), corner_vertices_(std::move(corner_vertices)) {
  // Sums over neighbours stay below 2^31.
  constexpr Eigen::Index kMostVertices = 100'000'000;
  constexpr size_t kMostCorners = 500'000'000;
  if (positions_.rows() > kMostVertices || corner_vertices_.size() > kMostCorners)
    throw InvalidInput(text("the mesh has ", positions_.rows(), " vertices and ", corner_vertices_.size(),
                            " corners of faces, must have at most ", kMostVertices, " and ", kMostCorners,
                            "; pose a coarser one"));
  if (positions_.rows() == 0) throw InvalidInput("rest_positions is empty; the mesh needs at least one vertex");
  require_finite_positions(positions_);
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
    throw InvalidInput(text("corner_vertices has ", corner_vertices_.size(), " entries, but face_sizes adds up to ",
                            n_corners, n_corners > static_cast<int64_t>(corner_vertices_.size()) ? " or more" : ""));

  UnionFind parts(n_vertices());
  std::vector<char> is_in_face(n_vertices(), 0);
  for (int f = 0; f < n_faces(); ++f) {
    const int first = face(f).front();
    for (const int v : face(f)) {
      if (v < 0 || v >= n_vertices())
        throw InvalidInput(
            text("face ", f, " names vertex ", v, ", but the mesh has vertices 0 to ", n_vertices() - 1));
      is_in_face[v] = 1;
      parts.join(first, v);
    }
  }
  part_of_vertex_.assign(n_vertices(), -1);
  for (int v = 0; v < n_vertices(); ++v) {
    if (is_in_face[v] == 0) {
      loose_vertices_.push_back(v);
      continue;
    }
    const int root = parts.find(v);
    part_of_vertex_[v] = root == v ? n_parts_++ : part_of_vertex_[root];
  }
}

double PolygonMesh::diagonal() const { return surface_box(*this).diagonal().norm(); }

}  // namespace arap
