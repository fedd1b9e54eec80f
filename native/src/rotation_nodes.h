// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "cell_energy.h"
#include "surface_distance.h"

namespace arap {

/// Rotation nodes: points of the surface, about a radius r apart at any density of the mesh. A vertex looks at the
/// nodes within 2 r of it along the surface, with the weights w_jc = a_c (1 - d^2 / s_j^2), scaled to sum 1. a_c is the
/// area of the surface nearest to the node; s_j is 2 r where triangles are small, and less by what they spread a weight
/// where they are large.
struct RotationNodes {
  std::vector<int> vertices;    ///< of each node
  std::vector<int> offsets;     ///< n_vertices + 1: the nodes of vertex j are entries [offset j, offset j + 1)
  std::vector<int> nodes;       ///< of each entry
  std::vector<double> weights;  ///< of each entry

  [[nodiscard]] int size() const { return static_cast<int>(vertices.size()); }
};

/// How far a weight at a vertex is spread by the faces at it, squared, (n,): their mean of the mean squared distance of
/// corners from their centre; 0 in no face.
[[nodiscard]] std::vector<double> face_spreads(const PolygonMesh& mesh);

/// Chooses them: greedily, in the order of the vertices, so that every vertex is nearer than r to a node. Which are
/// chosen depends on the mesh alone.
/// @param spreads  as face_spreads
/// @param areas    (n,) of the surface at each vertex
/// @param radius   r > 0
/// @param mirrors  vertex maps of the mesh's mirror symmetries, each its own inverse: nodes are symmetric then
/// @param group    (n,) or empty: nodes of one group do not count as near for another's vertices
[[nodiscard]] RotationNodes choose_rotation_nodes(const SurfaceGraph& graph, const std::vector<double>& spreads,
                                                  const std::vector<double>& areas, double radius,
                                                  const std::vector<std::vector<int>>& mirrors,
                                                  const std::vector<int>& group, int threads);

/// One at each vertex, which looks at no other.
[[nodiscard]] RotationNodes node_at_each_vertex(int n_vertices);

}  // namespace arap
