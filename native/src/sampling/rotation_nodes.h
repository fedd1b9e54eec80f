// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "parallel/meter.h"
#include "sampling/edge_graph.h"

namespace arap {

/// Rotation nodes: a smooth version of rotation clusters [Jacobson et al. 2012]. They are vertices about a radius r
/// apart along the surface, whatever the density of the mesh. Vertex j uses the nodes c within its support s_j with the
/// weights w_jc = a_c (1 - d^2 / s_j^2), normalized to sum 1. a_c is the area that the node stands for: its Voronoi
/// cell, corrected so that the sums before normalization are about equal. s_j is 2 r, less on large triangles, which
/// spread weights themselves.
struct RotationNodes {
  std::vector<int> vertices;    ///< of each node
  std::vector<int> offsets;     ///< (n + 1,): vertex j has the entries [offsets[j], offsets[j + 1])
  std::vector<int> nodes;       ///< of each entry
  std::vector<double> weights;  ///< of each entry

  [[nodiscard]] int size() const { return static_cast<int>(vertices.size()); }
};

/// (n,) mean variance of the faces at each vertex: the mean squared distance of a face's corners from its centre. 0 for
/// an isolated vertex.
[[nodiscard]] std::vector<double> face_variances(const PolygonMesh& mesh);

/// Places the nodes by sample_poisson_disk, whose parameters these are, and computes the weights. The result depends on
/// the mesh alone, not on `threads`.
[[nodiscard]] RotationNodes choose_rotation_nodes(const EdgeGraph& graph, const PolygonMesh& mesh,
                                                  const std::vector<double>& areas, double radius,
                                                  const std::vector<std::vector<int>>& mirrors,
                                                  const std::vector<int>& group, int threads,
                                                  const MeterPart& meter = {});

/// One node at each vertex, used by this vertex alone.
[[nodiscard]] RotationNodes node_at_each_vertex(int n_vertices);

}  // namespace arap
