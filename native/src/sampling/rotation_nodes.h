// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "sampling/surface_distance.h"

namespace arap {

/// Rotation nodes: points of the surface, about a radius r apart at any density of the mesh. A vertex looks at the
/// nodes within 2 r of it along the surface, with the weights w_jc = a_c (1 - d^2 / s_j^2), scaled to sum 1. a_c is
/// what the node stands for: the area nearest to it, corrected so that the sums before scaling are about even. s_j is 2
/// r where triangles are small, and less by what they spread a weight where they are large.
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

/// Chooses them, as choose_nodes. Which are chosen depends on the mesh alone.
/// @param mesh  of the graph's vertices, for all else as there
[[nodiscard]] RotationNodes choose_rotation_nodes(const SurfaceGraph& graph, const PolygonMesh& mesh,
                                                  const std::vector<double>& areas, double radius,
                                                  const std::vector<std::vector<int>>& mirrors,
                                                  const std::vector<int>& group, int threads);

/// One at each vertex, which looks at no other.
[[nodiscard]] RotationNodes node_at_each_vertex(int n_vertices);

}  // namespace arap
