// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "sampling/edge_graph.h"

namespace arap {

/// (n,) surface area at each vertex: every face gives equal shares to its corners.
[[nodiscard]] std::vector<double> vertex_areas(const PolygonMesh& mesh);

/// Throws InvalidInput, naming the vertex or the radius, if no patch can lie around `vertices`.
/// @param part_of_vertex  (n,) connected component, -1 for isolated vertices
void require_patch_sources(const std::vector<int>& vertices, double radius, const std::vector<int>& part_of_vertex);

/// A round patch: the vertices nearer to one of `sources` than `radius`, with weights area (1 - d^2 / radius^2)^3 that
/// fade out with the distance d.
/// @param areas  as vertex_areas; if all are 0 in the patch, every vertex counts the same
/// @param rest   (n, 3)
[[nodiscard]] Patch find_patch(const EdgeGraph& graph, const std::vector<double>& areas, const Positions& rest,
                               const std::vector<int>& sources, double radius);

}  // namespace arap
