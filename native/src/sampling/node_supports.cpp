// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/node_supports.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <span>

#include "parallel/parallel.h"
#include "sampling/dijkstra.h"

namespace arap {

namespace {

using Supports = std::vector<std::vector<Reached>>;

/// One sweep a node; empty if some vertex has more than kMostNodes nodes.
Supports sweep_each(const EdgeGraph& graph, const std::vector<int>& nodes, float support, int threads,
                    const MeterPart& meter) {
  Supports supports(nodes.size());
  const std::int64_t most = std::int64_t{kMostNodes} * graph.n_vertices();
  std::atomic<std::int64_t> n_reached = 0;
  std::atomic<size_t> next = 0;
  for_each_piece(threads, threads, [&](int /*thread*/) {
    TruncatedDijkstra sweep(graph);
    std::vector<Reached> reached;
    for (size_t c = next++; c < nodes.size() && n_reached <= most; c = next++) {
      reached.clear();
      sweep.run(std::span(&nodes[c], 1), support, [&](int vertex, float distance) {
        reached.push_back({vertex, distance});
      });
      n_reached += std::ssize(reached);
      supports[c] = reached;
      meter.add(1 / static_cast<double>(nodes.size()));
    }
  });
  if (n_reached > most) return {};
  std::vector<int> n_nodes(graph.n_vertices(), 0);
  for (const std::vector<Reached>& of_node : supports)
    for (const Reached& reached : of_node)
      if (++n_nodes[reached.vertex] > kMostNodes) return {};
  return supports;
}

/// Dijkstra's algorithm from all nodes at once. A vertex is settled once by each of its nearest nodes. What is nearest
/// to a vertex is nearest to those on the shortest path, too, so nothing passes a vertex that has nearer nodes enough.
class NearestNodes {
 public:
  NearestNodes(const EdgeGraph& graph, const std::vector<int>& nodes, float support, const MeterPart& meter)
      : graph_(graph), support_(support), meter_(meter), supports_(nodes.size()), nearest_(graph.n_vertices()) {
    for (size_t c = 0; c < nodes.size(); ++c) reach(nodes[c], static_cast<int>(c), 0);
  }

  Supports run() {
    while (!queue_.empty()) {
      const auto [distance, key] = queue_.pop();
      const auto vertex = static_cast<int>(static_cast<std::uint32_t>(key) / kMostNodes);
      const Nearest& nearest = nearest_[vertex];
      const std::uint32_t slot = static_cast<std::uint32_t>(key) % kMostNodes;
      if (nearest.distances[slot] != distance) continue;  // a nearer one has come
      const int node = nearest.nodes[slot];
      count_settled();
      supports_[node].push_back({vertex, distance});
      for (const EdgeGraph::Arc& arc : graph_.arcs(vertex)) nearest_[arc.vertex].prefetch();
      for (const EdgeGraph::Arc& arc : graph_.arcs(vertex)) reach(arc.vertex, node, distance + arc.length);
    }
    return std::move(supports_);
  }

 private:
  /// The nearest nodes of a vertex so far. The distance of a slot only falls.
  struct Nearest {
    Nearest() {
      distances.fill(std::numeric_limits<float>::infinity());
      nodes.fill(-1);
    }
    void prefetch() const {
      for (int k = 0; k < kMostNodes; k += 16) arap::prefetch(&nodes[k]);
      for (int k = 0; k < kMostNodes; k += 16) arap::prefetch(&distances[k]);
    }
    std::array<float, kMostNodes> distances{};
    std::array<int, kMostNodes> nodes{};
  };

  void count_settled() {
    constexpr int kReported = 1 << 16;
    // No vertex is settled more often than this.
    if (++n_settled_ % kReported == 0) meter_.add(kReported / (1.0 * kMostNodes * graph_.n_vertices()));
  }

  /// A node takes its own slot at a vertex, or that of the farthest one.
  void reach(int vertex, int node, float distance) {
    if (!(distance < support_)) return;
    Nearest& nearest = nearest_[vertex];
    const auto own = std::find(nearest.nodes.begin(), nearest.nodes.end(), node) - nearest.nodes.begin();
    const auto slot = own < kMostNodes ? own : std::ranges::max_element(nearest.distances) - nearest.distances.begin();
    if (!(distance < nearest.distances[slot])) return;
    nearest.distances[slot] = distance;
    nearest.nodes[slot] = node;
    queue_.push({distance,
                 static_cast<int>(static_cast<std::uint32_t>(vertex) * kMostNodes + static_cast<std::uint32_t>(slot))});
  }

  const EdgeGraph& graph_;
  float support_;
  MeterPart meter_;
  std::int64_t n_settled_ = 0;
  Supports supports_;
  std::vector<Nearest> nearest_;  ///< of each vertex
  DistanceQueue queue_;           ///< of slots: vertex * kMostNodes + slot
};

}  // namespace

Supports find_supports(const EdgeGraph& graph, const std::vector<int>& nodes, float support, int threads,
                       const MeterPart& meter) {
  // Mostly a sweep is all.
  Supports supports = sweep_each(graph, nodes, support, threads, meter.part(0.7));
  if (supports.empty() && !nodes.empty()) supports = NearestNodes(graph, nodes, support, meter.part(0.3)).run();
  return supports;
}

}  // namespace arap
