// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/node_supports.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "sampling/dijkstra.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using NodesOf = std::vector<std::map<int, float>>;

/// Of each vertex its nodes with their distances.
NodesOf found(const arap::EdgeGraph& graph, const std::vector<int>& nodes, float support, int threads = 2) {
  NodesOf result(static_cast<size_t>(graph.n_vertices()));
  const auto supports = arap::find_supports(graph, nodes, support, threads);
  for (size_t c = 0; c < supports.size(); ++c)
    for (const auto& [vertex, distance] : supports[c])
      EXPECT_TRUE(result[vertex].emplace(static_cast<int>(c), distance).second) << "vertex " << vertex;
  return result;
}

/// The same from the definition.
NodesOf expected(const arap::EdgeGraph& graph, const std::vector<int>& nodes, float support) {
  std::vector<std::vector<std::pair<float, int>>> all(static_cast<size_t>(graph.n_vertices()));
  arap::TruncatedDijkstra sweep(graph);
  for (int c = 0; c < std::ssize(nodes); ++c)
    sweep.run(std::span(&nodes[c], 1), support, [&](int vertex, float d) { all[vertex].emplace_back(d, c); });
  NodesOf result;
  for (auto& of_vertex : all) {
    std::sort(of_vertex.begin(), of_vertex.end());
    of_vertex.resize(std::min<size_t>(of_vertex.size(), arap::kMostNodes));
    std::map<int, float>& nearest = result.emplace_back();
    for (const auto& [distance, node] : of_vertex) nearest.emplace(node, distance);
  }
  return result;
}

TEST(NodeSupports, OfASurfaceAreAllThatIsNear) {
  const arap::EdgeGraph graph = edge_graph(bumpy_sphere(4));
  std::vector<int> nodes;
  for (int v = 0; v < graph.n_vertices(); v += 20) nodes.push_back(v);
  EXPECT_EQ(found(graph, nodes, .3F), expected(graph, nodes, .3F));
}

TEST(NodeSupports, OfACrowdedMeshAreTheNearest) {
  Random random(4);
  MeshData fan;
  fan.add_vertex(Vector3::Zero());
  for (int k = 0; k < 400; ++k) fan.add_vertex(random.vector(1));
  for (int k = 1; k < 400; k += 2) fan.faces.push_back({0, k, k + 1});
  std::vector<int> all_vertices(static_cast<size_t>(fan.n_vertices()));
  std::iota(all_vertices.begin(), all_vertices.end(), 0);
  const arap::EdgeGraph graph = edge_graph(fan);
  EXPECT_EQ(found(graph, all_vertices, .9F), expected(graph, all_vertices, .9F));
  EXPECT_EQ(found(graph, all_vertices, .9F, 1), found(graph, all_vertices, .9F, 3));
}

}  // namespace
}  // namespace arap_test
