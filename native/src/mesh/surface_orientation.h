// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap {

/// Where a surface has an inside, and which way that is.
struct SurfaceOrientation {
  Positions normals;             ///< (n, 3) unit, of vertices; 0 where there is none
  std::vector<char> has_inside;  ///< of each part
  std::vector<char> is_sound;    ///< of each vertex: all its edges are
};

/// An edge is sound where it is between two faces that run through it in opposite directions. A part has an inside
/// where its volume is positive and hardly an edge is not sound: discs around which these would fit have less than a
/// hundredth of its area. An open sheet has none, folded or not, nor has a part that is turned inside out.
[[nodiscard]] SurfaceOrientation find_orientation(const PolygonMesh& mesh, int threads);

}  // namespace arap
