// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/node_supports.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
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
/// to a vertex is nearest to those on the shortest path, too, so nothing passes a vertex that has its nodes.
class NearestNodes {
 public:
  NearestNodes(const EdgeGraph& graph, const std::vector<int>& nodes, float support, const MeterPart& meter)
      : graph_(graph), support_(support), meter_(meter), supports_(nodes.size()), nodes_of_(graph.n_vertices()) {
    for (size_t c = 0; c < nodes.size(); ++c) push({nodes[c], static_cast<int>(c)}, 0);
  }

  Supports run() {
    while (!queue_.empty()) {
      const auto [distance, slot] = queue_.pop();
      const Label label = labels_[slot];
      free_.push_back(slot);
      if (!may_settle(label)) continue;
      nodes_of_[label.vertex].push_back(label.node);
      count_settled();
      supports_[label.node].push_back({label.vertex, distance});
      for (const EdgeGraph::Arc& arc : graph_.arcs(label.vertex)) push({arc.vertex, label.node}, distance + arc.length);
    }
    return std::move(supports_);
  }

 private:
  struct Label {
    int vertex;
    int node;
  };

  [[nodiscard]] bool may_settle(const Label& label) const {
    const std::vector<int>& settled = nodes_of_[label.vertex];
    return std::ssize(settled) < kMostNodes && std::find(settled.begin(), settled.end(), label.node) == settled.end();
  }

  void count_settled() {
    constexpr int kReported = 1 << 16;
    // No vertex is settled more often than this.
    if (++n_settled_ % kReported == 0) meter_.add(kReported / (1.0 * kMostNodes * graph_.n_vertices()));
  }

  void push(const Label& label, float distance) {
    if (!(distance < support_) || !may_settle(label)) return;
    int slot = static_cast<int>(labels_.size());
    if (free_.empty()) {
      labels_.push_back(label);
    } else {
      slot = free_.back();
      free_.pop_back();
      labels_[slot] = label;
    }
    queue_.push({distance, slot});
  }

  const EdgeGraph& graph_;
  float support_;
  MeterPart meter_;
  std::int64_t n_settled_ = 0;
  Supports supports_;
  std::vector<std::vector<int>> nodes_of_;  ///< of each vertex, the nearest first
  DistanceQueue queue_;                     ///< of slots of labels_
  std::vector<Label> labels_;
  std::vector<int> free_;  ///< slots
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
