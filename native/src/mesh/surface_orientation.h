// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap {

/// Normals of a surface, and which of its connected components enclose a volume.
struct SurfaceOrientation {
  Positions normals;              ///< (n, 3) unit normals of vertices, 0 if the faces cancel out
  std::vector<char> has_inside;   ///< of each connected component
  std::vector<char> is_manifold;  ///< of each vertex: all its edges are regular
};

/// An edge is regular if it has two faces and they traverse it in opposite directions (manifold, consistently
/// oriented). A component has an inside if its volume is positive and nearly all of its edges are regular: a disc whose
/// circumference is the length of the others has less than a hundredth of its area. So neither an open sheet, folded or
/// not, nor a component that is turned inside out has one.
[[nodiscard]] SurfaceOrientation find_orientation(const PolygonMesh& mesh, int threads);

}  // namespace arap
