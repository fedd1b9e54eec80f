// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "sampling/surface_distance.h"

namespace arap {

/// Area of the surface at each vertex, (n,): of each face the same share for all of its corners.
[[nodiscard]] std::vector<double> vertex_areas(const PolygonMesh& mesh);

/// Throws InvalidInput where no patch can lie around `vertices`, naming the vertex or the radius.
/// @param part_of_vertex  (n,) connected part, -1 = in no face
void require_patch_sources(const std::vector<int>& vertices, double radius, const std::vector<int>& part_of_vertex);

/// A round patch that fades out: the vertices nearer to one of `sources` than `radius`, with the weights
/// area (1 - d^2 / radius^2)^3.
/// @param areas  as vertex_areas; where a whole patch has none, every vertex counts the same
/// @param rest   (n, 3)
[[nodiscard]] Patch find_patch(const SurfaceGraph& graph, const std::vector<double>& areas, const Positions& rest,
                               const std::vector<int>& sources, double radius);

}  // namespace arap
