// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace arap {

/// Optional properties of the vertices of a mesh, fixed at bind. Empty vectors: not used.
struct VertexProperties {
  std::vector<double> stiffness;   ///< (n,) 1e-12 to 1e12, scales the energy around a vertex; 1 is normal
  std::vector<int> rigid_regions;  ///< (n,) region of each vertex, < 0 = none; a region moves as one rigid body

  /// Throws InvalidInput that names the length or the vertex.
  void validate(int n_vertices) const;
};

}  // namespace arap
