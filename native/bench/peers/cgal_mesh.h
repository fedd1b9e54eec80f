// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <stdexcept>

namespace arap::bench {

using CgalKernel = CGAL::Simple_cartesian<double>;
using CgalMesh = CGAL::Surface_mesh<CgalKernel::Point_3>;

inline CgalMesh::Vertex_index cgal_vertex(int v) { return CgalMesh::Vertex_index(static_cast<CgalMesh::size_type>(v)); }

/// CGAL's mesh of (n, 3) positions and (m, 3) triangles. Throws std::runtime_error where it takes no such mesh.
inline CgalMesh cgal_mesh(const double* positions, int n_vertices, const int* triangles, int n_triangles) {
  CgalMesh mesh;
  for (int v = 0; v < n_vertices; ++v) mesh.add_vertex({positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]});
  for (const int* corner = triangles; corner != triangles + 3 * n_triangles; corner += 3) {
    if (mesh.add_face(cgal_vertex(corner[0]), cgal_vertex(corner[1]), cgal_vertex(corner[2])) == CgalMesh::null_face())
      throw std::runtime_error("the mesh is not manifold or not consistently oriented");
  }
  return mesh;
}

/// The positions of its vertices into (n, 3).
inline void copy_positions(const CgalMesh& mesh, double* out) {
  for (const auto v : mesh.vertices())
    for (int axis = 0; axis < 3; ++axis) *out++ = mesh.point(v)[axis];
}

}  // namespace arap::bench
