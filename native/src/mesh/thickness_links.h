// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "arap/mesh.h"

namespace arap {

/// Pairs (a, b), a < b, of vertices on opposite walls of a thin part: nearer to each other than `radius` straight
/// through the inside, their normals about opposite. The walls are those of one part that has an inside (see
/// SurfaceOrientation), and there is nothing of it in between: never across a gap, nor where limbs overlap. Where
/// vertices are much denser than the radius, some of them stand for their neighbours.
/// @param mirrors  vertex maps of the mesh's mirror symmetries: images of bridges are bridges
[[nodiscard]] std::vector<std::pair<int, int>> find_thickness_links(const PolygonMesh& mesh, double radius,
                                                                    const std::vector<std::vector<int>>& mirrors,
                                                                    int threads);

}  // namespace arap
