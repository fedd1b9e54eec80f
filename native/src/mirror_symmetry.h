// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"

namespace arap {

/// How far the image of a vertex may be from another one, as a part of the mesh's diagonal.
inline constexpr double kMirrorTolerance = 1e-4;

/// The vertex at each vertex' mirror image, for every one of the planes x = 0, y = 0, z = 0 under which all vertices
/// have one. Vertices are compared, not faces.
/// @param rest     (n, 3) centred at its bounding box, of a size of about 1
/// @param threads  to work on
[[nodiscard]] std::vector<std::vector<int>> find_mirrors(const Positions& rest, int threads);

}  // namespace arap
