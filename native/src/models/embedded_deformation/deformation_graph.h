// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "arap/embedded_deformation.h"
#include "arap/mesh.h"
#include "arap/types.h"
#include "constraints/linear_rows.h"
#include "parallel/meter.h"
#include "parallel/workers.h"

namespace arap {

/// The state of m nodes, (4 m, 3): rows 4 j to 4 j + 2 are the columns of A_j, row 4 j + 3 is t_j. So what the nodes
/// make of a point is linear in the rows, with the same coefficients for x, y and z.
inline constexpr int kNodeRows = 4;

/// The rows of a node.
[[nodiscard]] inline auto rows_of(Positions& state, int node) {
  return state.middleRows<kNodeRows>(Eigen::Index{kNodeRows} * node);
}
[[nodiscard]] inline auto rows_of(const Positions& state, int node) {
  return state.middleRows<kNodeRows>(Eigen::Index{kNodeRows} * node);
}

/// Nodes on a mesh, and which of them move a vertex. In model space.
struct DeformationGraph {
  Positions rest;                          ///< (n, 3) of the mesh
  std::vector<int> vertices;               ///< (m,) of each node
  std::vector<int> offsets;                ///< (n + 1,): vertex v has the entries [offsets[v], offsets[v + 1])
  std::vector<int> nodes;                  ///< of each entry
  std::vector<double> weights;             ///< of each entry; of a vertex they sum to 1
  std::vector<std::pair<int, int>> edges;  ///< (j, k), j < k: some vertex has both

  [[nodiscard]] int size() const { return static_cast<int>(vertices.size()); }
  [[nodiscard]] auto node(int j) const { return rest.row(vertices[j]); }

  /// The state in which nothing is moved.
  [[nodiscard]] Positions rest_state() const;
  /// Where the mesh is, (n, 3). Loose vertices are at rest.
  void move(const Positions& state, const Workers& workers, Positions& result) const;
  /// A combination of vertices as a combination of the rows of a state, and what is to be added to it.
  struct Combination {
    LinearRow row;
    Eigen::RowVector3d constant = Eigen::RowVector3d::Zero();
  };
  [[nodiscard]] Combination of_state(const std::vector<int>& vertices, const std::vector<double>& factors) const;
};

/// @param mesh  in model space: centred, diagonal 1
[[nodiscard]] DeformationGraph make_graph(const PolygonMesh& mesh, const EmbeddedOptions& options, int threads,
                                          const MeterPart& meter);

}  // namespace arap
