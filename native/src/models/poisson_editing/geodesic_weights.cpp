// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/poisson_editing/geodesic_weights.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "base/available_memory.h"
#include "parallel/parallel.h"
#include "sampling/dijkstra.h"

namespace arap {

namespace {

/// What is nearer to a handle counts as in it: it has the handle's value but for rounding.
constexpr double kNearest = 1e-12;

/// The nearest vertex of a handle to each vertex.
struct Nearest {
  std::vector<float> distance;  ///< infinity: none
  std::vector<int> row;
};

Nearest find_nearest(const EdgeGraph& graph, const std::vector<HandleVertex>& handle) {
  const auto n = static_cast<size_t>(graph.n_vertices());
  Nearest nearest{std::vector<float>(n, std::numeric_limits<float>::infinity()), std::vector<int>(n, 0)};
  DistanceQueue queue;
  for (const HandleVertex& source : handle) {
    nearest.distance[source.vertex] = 0;
    nearest.row[source.vertex] = source.row;
    queue.push({0, source.vertex});
  }
  while (!queue.empty()) {
    const auto [distance, near] = queue.pop();
    if (distance > nearest.distance[near]) continue;
    for (const EdgeGraph::Arc& arc : graph.arcs(near)) {
      const float further = distance + arc.length;
      if (further >= nearest.distance[arc.vertex]) continue;
      nearest.distance[arc.vertex] = further;
      nearest.row[arc.vertex] = nearest.row[near];
      queue.push({further, arc.vertex});
    }
  }
  return nearest;
}

}  // namespace

GeodesicWeights::GeodesicWeights(const EdgeGraph& graph, const std::vector<std::vector<HandleVertex>>& handles,
                                 int threads, const MeterPart& meter)
    : n_(graph.n_vertices()), n_handles_(static_cast<int>(handles.size())) {
  const size_t size = static_cast<size_t>(n_) * handles.size();
  require_memory(static_cast<double>(size) * (sizeof(double) + sizeof(int)),
                 "the distance of each vertex to each handle");
  weights_.resize(size);
  rows_.resize(size);
  for_each_piece(threads, n_handles_, [&](int h) {
    const Nearest nearest = find_nearest(graph, handles[h]);
    for (int v = 0; v < n_; ++v) {
      const size_t entry = static_cast<size_t>(v) * n_handles_ + h;
      weights_[entry] = 1 / std::max(kNearest, static_cast<double>(nearest.distance[v]));
      rows_[entry] = nearest.row[v];
    }
    meter.add(1.0 / n_handles_);
  });
  for (int v = 0; v < n_; ++v) {
    const std::ptrdiff_t first = std::ptrdiff_t{v} * n_handles_;
    Eigen::Map<Eigen::VectorXd> weights(weights_.data() + first, n_handles_);
    if (const double sum = weights.sum(); sum > 0) weights /= sum;
  }
}

Positions GeodesicWeights::blend(const Positions& of_rows, const Workers& workers) const {
  Positions result(n_, 3);
  parallel_for(workers, n_, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (int h = 0; h < n_handles_; ++h) {
        const size_t entry = static_cast<size_t>(v) * n_handles_ + h;
        sum += weights_[entry] * of_rows.row(rows_[entry]);
      }
      result.row(v) = sum;
    }
  });
  return result;
}

}  // namespace arap
