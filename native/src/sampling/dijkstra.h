// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "sampling/edge_graph.h"

namespace arap {

/// Priority queue of Dijkstra's algorithm: pops the nearest vertex, the lowest one of equally near. A radix heap
/// [Ahuja, Mehlhorn, Orlin, Tarjan 1990]: until it is empty, nothing nearer than the last popped entry may be pushed.
/// Equal entries are kept once.
class DistanceQueue {
 public:
  struct Entry {
    float distance;
    int vertex;
  };

  [[nodiscard]] bool empty() const { return filled_ == 0; }
  void push(Entry entry) {
    put(static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(entry.distance)) << 32U |
        static_cast<std::uint32_t>(entry.vertex));
  }
  Entry pop() {
    const int first = std::countr_zero(filled_);
    filled_ &= filled_ - 1;
    std::vector<std::uint64_t>& keys = buckets_[first];
    const std::uint64_t least = *std::min_element(keys.begin(), keys.end());
    last_ = least;
    for (const std::uint64_t key : keys)
      if (key != least) put(key);  // into buckets before this one
    keys.clear();
    if (empty()) last_ = 0;
    return {std::bit_cast<float>(static_cast<std::uint32_t>(least >> 32U)), static_cast<int>(least & 0xFFFFFFFFU)};
  }

 private:
  void put(std::uint64_t key) {
    const auto bucket = static_cast<unsigned>(std::bit_width(key ^ last_));
    buckets_[bucket].push_back(key);
    filled_ |= std::uint64_t{1} << bucket;
  }

  /// Keys by the highest bit in which they differ from the last popped key. The bits of a float >= 0 sort as the float
  /// does, and its highest bit is 0.
  std::array<std::vector<std::uint64_t>, 64> buckets_;
  std::uint64_t filled_ = 0;  ///< one bit per bucket
  std::uint64_t last_ = 0;
};

/// Shortens distances along the graph, from the vertices in the queue on.
/// @param distance  (n,) at most what is known
/// @param reach     reach(from, to) takes note of a shorter way, or returns false: there is none
template <class Reach>
void shorten_distances(const EdgeGraph& graph, DistanceQueue& queue, std::vector<float>& distance, const Reach& reach) {
  while (!queue.empty()) {
    const auto [so_far, near] = queue.pop();
    if (so_far > distance[near]) continue;
    for (const EdgeGraph::Arc& arc : graph.arcs(near)) {
      const float further = so_far + arc.length;
      if (further >= distance[arc.vertex] || !reach(near, arc.vertex)) continue;
      distance[arc.vertex] = further;
      queue.push({further, arc.vertex});
    }
  }
}

/// Shortest paths from a few vertices up to a radius, for many calls.
class TruncatedDijkstra {
 public:
  explicit TruncatedDijkstra(const EdgeGraph& graph) : graph_(graph), distance_(graph.n_vertices(), kFar) {}

  /// Calls visit(vertex, distance) for every vertex nearer to one of `sources` than `radius`, in no particular order.
  template <class Visit>
  void run(std::span<const int> sources, float radius, const Visit& visit) {
    const auto ring_of = [&](float distance) {
      return std::min(static_cast<size_t>(distance / radius * kRings), kRings - 1);
    };
    for (const int source : sources) reach(source, 0, 0);
    for (size_t ring = 0; n_waiting_ > 0; ++ring) {
      // The loop below may add to this ring.
      while (!rings_[ring].empty()) {
        std::swap(present_, rings_[ring]);
        n_waiting_ -= present_.size();
        for (const Waiting& next : present_) {
          if (next.distance > distance_[next.vertex]) continue;
          for (const EdgeGraph::Arc& arc : graph_.arcs(next.vertex)) {
            const float further = next.distance + arc.length;
            if (further < radius && further < distance_[arc.vertex]) reach(arc.vertex, further, ring_of(further));
          }
        }
        present_.clear();
      }
    }
    for (const int vertex : reached_) {
      visit(vertex, distance_[vertex]);
      distance_[vertex] = kFar;
    }
    reached_.clear();
  }

 private:
  static constexpr float kFar = std::numeric_limits<float>::infinity();
  static constexpr size_t kRings = 256;

  struct Waiting {
    float distance;
    int vertex;
  };

  void reach(int vertex, float distance, size_t ring) {
    if (distance_[vertex] == kFar) reached_.push_back(vertex);
    distance_[vertex] = distance;
    graph_.prefetch_arcs(vertex);
    rings_[ring].push_back({distance, vertex});
    ++n_waiting_;
  }

  const EdgeGraph& graph_;
  std::vector<float> distance_;  ///< kFar outside of run()
  std::vector<int> reached_;
  /// Queued vertices by distance. A ring is not sorted: a vertex that is reached later on a shorter path is queued
  /// again [Meyer and Sanders 2003, delta-stepping]. That is rare and costs less than sorting.
  std::array<std::vector<Waiting>, kRings> rings_;
  std::vector<Waiting> present_;  ///< the ring at hand
  size_t n_waiting_ = 0;          ///< in all rings
};

}  // namespace arap
