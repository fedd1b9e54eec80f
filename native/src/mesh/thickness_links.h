// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "arap/mesh.h"
#include "parallel/meter.h"

namespace arap {

/// Pairs (a, b), a < b, of vertices on opposite walls of a thin limb: nearer than `radius` straight through the inside,
/// with about opposite normals. Both walls belong to one connected component that has an inside (see
/// SurfaceOrientation), and nothing of it is in between: there are no links across a gap or between limbs that overlap.
/// If vertices are much denser than the radius, some of them represent their neighbours.
/// @param mirrors  vertex maps of the mesh's mirror symmetries: images of links are links
[[nodiscard]] std::vector<std::pair<int, int>> find_thickness_links(const PolygonMesh& mesh, double radius,
                                                                    const std::vector<std::vector<int>>& mirrors,
                                                                    int threads, const MeterPart& meter = {});

}  // namespace arap
