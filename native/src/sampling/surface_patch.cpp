// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/surface_patch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "mesh/surface_measures.h"
#include "sampling/dijkstra.h"

namespace arap {

namespace {

/// (1 - d^2 / s^2)^3, 0 from s on.
double faded(double distance, double support) {
  const double part = distance / support;
  const double closeness = part < 1 ? 1 - part * part : 0;
  return closeness * closeness * closeness;
}

}  // namespace

void require_patch_sources(const std::vector<int>& vertices, double radius, const std::vector<int>& part_of_vertex) {
  if (vertices.empty()) throw InvalidInput("a patch needs at least one vertex to lie around, but none was given");
  if (!(radius >= 0) || std::isinf(radius))
    throw InvalidInput(text("radius = ", radius, ", must be finite and >= 0; 0 is the default"));
  const auto n = static_cast<int>(part_of_vertex.size());
  for (const int v : vertices) {
    if (v < 0 || v >= n) throw InvalidInput(text("vertex ", v, " is out of range, the mesh has vertices 0 to ", n - 1));
    if (part_of_vertex[v] < 0)
      throw InvalidInput(text("vertex ", v, " is in no face, so no patch lies around it; constrain the vertex itself"));
  }
}

std::vector<double> vertex_areas(const PolygonMesh& mesh) {
  std::vector<double> areas(mesh.n_vertices(), 0.0);
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    const double area = twice_vector_area(mesh.positions(), face).norm() / 2;
    for (const int v : face) areas[v] += area / static_cast<double>(face.size());
  }
  return areas;
}

Patch find_patch(const EdgeGraph& graph, const std::vector<double>& areas, const Positions& rest,
                 const std::vector<int>& sources, double radius) {
  std::vector<std::pair<float, int>> nearest_first;
  TruncatedDijkstra(graph).run(sources, static_cast<float>(radius),
                               [&](int vertex, float distance) { nearest_first.emplace_back(distance, vertex); });
  std::sort(nearest_first.begin(), nearest_first.end());
  Patch patch;
  std::vector<double> fades;
  double total = 0;
  for (const auto& [distance, vertex] : nearest_first) {
    patch.vertices.push_back(vertex);
    fades.push_back(faded(static_cast<double>(distance), radius));
    patch.weights.push_back(areas[vertex] * fades.back());
    total += patch.weights.back();
  }
  if (total <= 0) {
    patch.weights = fades;
    total = 0;
    for (const double fade : fades) total += fade;
  }
  for (size_t k = 0; k < patch.vertices.size(); ++k) {
    patch.weights[k] /= total;
    patch.rest_position += patch.weights[k] * rest.row(patch.vertices[k]).transpose();
  }
  return patch;
}

}  // namespace arap
