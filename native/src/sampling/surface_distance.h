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

#include "arap/types.h"
#include "sparse/sparse.h"

namespace arap {

/// The vertices of a surface, joined by straight segments.
class SurfaceGraph {
 public:
  struct Arc {
    int vertex;
    float length;
  };

  /// Joins the vertices that share a triangle, and others.
  /// @param K       (n, n) whose pattern says which ones these are, stored whole
  /// @param rest    (n, 3)
  /// @param others  pairs, each once
  SurfaceGraph(const SparseMatrix& K, const Positions& rest, int threads,
               const std::vector<std::pair<int, int>>& others = {});

  [[nodiscard]] int n_vertices() const { return static_cast<int>(offsets_.size()) - 1; }
  [[nodiscard]] std::span<const Arc> arcs(int vertex) const {
    return std::span(arcs_).subspan(offsets_[vertex], offsets_[vertex + 1] - offsets_[vertex]);
  }
  /// arcs(vertex) are soon asked for.
  void prefetch_arcs(int vertex) const { __builtin_prefetch(arcs_.data() + offsets_[vertex]); }

 private:
  std::vector<int> offsets_;
  std::vector<Arc> arcs_;
};

/// Vertices that wait for their turn, the nearest first, and the lowest of those as near: a radix heap [Ahuja,
/// Mehlhorn, Orlin, Tarjan 1990]. Until it is empty, nothing nearer than the last one popped may be pushed. Entries are
/// a set.
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

  /// Keys by the highest bit in which they differ from the last one popped; the bits of a distance >= 0 sort as it
  /// does, and the highest of them is 0.
  std::array<std::vector<std::uint64_t>, 64> buckets_;
  std::uint64_t filled_ = 0;  ///< a bit for each bucket
  std::uint64_t last_ = 0;
};

/// Distances along the graph from one or a few vertices, up to a radius, again and again.
class DistanceSweep {
 public:
  explicit DistanceSweep(const SurfaceGraph& graph) : graph_(graph), distance_(graph.n_vertices(), kFar) {}

  /// visit(vertex, distance) for every vertex nearer to one of `sources` than `radius`, in no particular order.
  template <class Visit>
  void run(std::span<const int> sources, float radius, const Visit& visit) {
    const auto ring_of = [&](float distance) {
      return std::min(static_cast<size_t>(distance / radius * kRings), kRings - 1);
    };
    for (const int source : sources) reach(source, 0, 0);
    for (size_t ring = 0; n_waiting_ > 0; ++ring) {
      // It may be filled again meanwhile.
      while (!rings_[ring].empty()) {
        std::swap(present_, rings_[ring]);
        n_waiting_ -= present_.size();
        for (const Waiting& next : present_) {
          if (next.distance > distance_[next.vertex]) continue;
          for (const SurfaceGraph::Arc& arc : graph_.arcs(next.vertex)) {
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

  const SurfaceGraph& graph_;
  std::vector<float> distance_;  ///< kFar but while it runs
  std::vector<int> reached_;
  /// Vertices that wait for their turn, by distance. In a ring they are in no order: what is reached on a shorter way
  /// afterwards has another turn [Meyer and Sanders 2003, delta-stepping]. That is seldom and costs less than an order,
  /// and the shortest way is the same.
  std::array<std::vector<Waiting>, kRings> rings_;
  std::vector<Waiting> present_;  ///< of a ring, while it is their turn
  size_t n_waiting_ = 0;          ///< in all rings
};

}  // namespace arap
