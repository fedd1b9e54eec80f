// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "parallel/meter.h"

namespace arap {

/// How far a vertex may be from the mirror image of another one, relative to the mesh's diagonal.
inline constexpr double kMirrorTolerance = 1e-4;

/// For each of the planes x = 0, y = 0, z = 0 that the mesh is symmetric to: the vertex at each vertex' mirror image.
/// Each map is its own inverse, and maps commute: planes without such a map are left out. Among vertices at one place,
/// as at an open seam, the one counts whose faces are mirrored too. An isolated vertex is its own image.
/// @param mesh     centred at its bounding box, diagonal about 1
/// @param threads  to work on
[[nodiscard]] std::vector<std::vector<int>> find_mirrors(const PolygonMesh& mesh, int threads,
                                                         const MeterPart& meter = {});

}  // namespace arap
