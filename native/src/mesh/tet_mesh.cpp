// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/tet_mesh.h"

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <utility>

#include "arap/error.h"
#include "arap/mesh.h"
#include "base/format_message.h"
#include "mesh/mesh_vertices.h"
#include "mesh/surface_measures.h"
#include "mesh/tet_shape.h"

namespace arap {

namespace {

std::string name_of(size_t t, const TetMesh::Tet& tet) {
  return text("tetrahedron ", t, " (", tet[0], ", ", tet[1], ", ", tet[2], ", ", tet[3], ")");
}

void require_vertices(size_t t, const TetMesh::Tet& tet, int n_vertices) {
  for (const int v : tet)
    if (v < 0 || v >= n_vertices)
      throw InvalidInput(text(name_of(t, tet), " names vertex ", v, ", but the mesh has vertices 0 to ", n_vertices - 1,
                              "; correct or remove it"));
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b)
      if (tet[a] == tet[b])
        throw InvalidInput(
            text(name_of(t, tet), " has vertex ", tet[a], " twice; give it four different vertices or remove it"));
}

/// -1 or 1, or 0 if the volume is not more than rounding.
int orientation(Matrix3 edges) {
  constexpr double kRounding = 1e-13;
  const double size = edges.cwiseAbs().maxCoeff();
  if (size == 0) return 0;
  edges /= size;  // products of tiny lengths would be 0
  const double volume = edges.determinant();
  if (!(std::abs(volume) > kRounding * edges.colwise().norm().prod())) return 0;
  return volume > 0 ? 1 : -1;
}

}  // namespace

TetMesh::TetMesh(Positions positions, std::vector<Tet> tets)
    : positions_(std::move(positions)), tets_(std::move(tets)) {
  constexpr size_t kMostTets = kMostCorners / 4;
  if (positions_.rows() > kMostVertices || tets_.size() > kMostTets)
    throw InvalidInput(text("the mesh has ", positions_.rows(), " vertices and ", tets_.size(),
                            " tetrahedra, must have at most ", kMostVertices, " and ", kMostTets,
                            "; pose a coarser one"));
  require_rest_positions(positions_);
  MeshPartFinder finder(n_vertices());
  for (size_t t = 0; t < tets_.size(); ++t) {
    Tet& tet = tets_[t];
    require_vertices(t, tet, n_vertices());
    const int side = orientation(tet_edges(positions_, tet));
    if (side == 0)
      throw InvalidInput(text(name_of(t, tet),
                              " has no volume; move one of its vertices out of the plane of the others or remove it"));
    if (side < 0) std::swap(tet[2], tet[3]);
    finder.add(tet);
  }
  MeshParts parts = std::move(finder).parts();
  part_of_vertex_ = std::move(parts.part_of_vertex);
  loose_vertices_ = std::move(parts.loose_vertices);
  n_parts_ = parts.n_parts;
}

int TetMesh::n_parts_joined(int threads) const {
  if (n_parts_ < 2) return n_parts_;
  // Its parts are those of polygons of the same corners.
  std::vector<int> corners;
  corners.reserve(4 * tets_.size());
  for (const Tet& tet : tets_) corners.insert(corners.end(), tet.begin(), tet.end());
  return PolygonMesh(positions_, std::move(corners), std::vector<int>(tets_.size(), 4)).n_parts_joined(threads);
}

double TetMesh::diagonal() const { return box_of_parts(positions_, part_of_vertex_).diagonal().norm(); }

}  // namespace arap
