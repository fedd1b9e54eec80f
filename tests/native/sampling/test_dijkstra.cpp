// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/dijkstra.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

/// Relaxes all arcs until no path gets shorter.
std::vector<float> reference_distances(const arap::EdgeGraph& graph, const std::vector<int>& sources) {
  std::vector<float> distances(graph.n_vertices(), kFar);
  for (const int source : sources) distances[source] = 0;
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (int v = 0; v < graph.n_vertices(); ++v)
      for (const auto& arc : graph.arcs(v))
        if (distances[v] + arc.length < distances[arc.vertex]) {
          distances[arc.vertex] = distances[v] + arc.length;
          has_changed = true;
        }
  }
  return distances;
}

std::map<int, float> swept(arap::TruncatedDijkstra& sweep, const std::vector<int>& sources, float radius) {
  std::map<int, float> distances;
  sweep.run(sources, radius, [&](int vertex, float distance) {
    EXPECT_TRUE(distances.emplace(vertex, distance).second) << vertex << " is visited twice";
  });
  return distances;
}

TEST(TruncatedDijkstra, FindsShortestPathsUpToTheRadius) {
  for (const MeshData& mesh : all_small_meshes()) {
    const arap::EdgeGraph graph = edge_graph(mesh);
    arap::TruncatedDijkstra sweep(graph);
    for (const std::vector<int>& sources : {std::vector<int>{0}, std::vector<int>{0, mesh.n_vertices() - 1}}) {
      const std::vector<float> expected = reference_distances(graph, sources);
      for (const double part : {1e-3, .2, 10.}) {
        const auto radius = static_cast<float>(part * mesh.diagonal());
        const std::map<int, float> distances = swept(sweep, sources, radius);
        for (int v = 0; v < mesh.n_vertices(); ++v) {
          const auto found = distances.find(v);
          EXPECT_EQ(found == distances.end() ? kFar : found->second, expected[v] < radius ? expected[v] : kFar)
              << mesh.name << ", vertex " << v;
        }
      }
    }
  }
}

/// About ten vertices per ring, so that longer paths are found first.
TEST(TruncatedDijkstra, FindsShortestPathsOnAMeshFarFinerThanTheRadius) {
  const MeshData mesh = grid(60, Faces::kQuads, [](double x, double y) { return .1 * x * x * y; });
  const arap::EdgeGraph graph = edge_graph(mesh);
  arap::TruncatedDijkstra sweep(graph);
  const std::vector<float> expected = reference_distances(graph, {7});
  for (const auto& [vertex, distance] : swept(sweep, {7}, 100)) EXPECT_EQ(distance, expected[vertex]);
}

}  // namespace
}  // namespace arap_test
