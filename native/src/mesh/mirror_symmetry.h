// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"

namespace arap {

/// How far the image of a vertex may be from another one, as a part of the mesh's diagonal.
inline constexpr double kMirrorTolerance = 1e-4;

/// The vertex at each vertex' mirror image, for the planes x = 0, y = 0, z = 0 under which all vertices have one. Each
/// map is its own inverse, and one after the other gives the same in either order: planes for which none such is found
/// are left out. Vertices at one place, as at an open seam, are told apart by their neighbours. A loose one, which may
/// be anywhere, is its own image.
/// @param mesh     centred at its bounding box, of a size of about 1
/// @param threads  to work on
[[nodiscard]] std::vector<std::vector<int>> find_mirrors(const PolygonMesh& mesh, int threads);

}  // namespace arap
