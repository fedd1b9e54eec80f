// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/poisson_editing/handle_weights.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "base/available_memory.h"
#include "optimize/harmonic_field.h"
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
  shorten_distances(graph, queue, nearest.distance, [&](int from, int to) {
    nearest.row[to] = nearest.row[from];
    return true;
  });
  return nearest;
}

}  // namespace

HandleWeights::HandleWeights(int n_vertices, int n_handles) : n_(n_vertices), n_handles_(n_handles) {
  const size_t size = static_cast<size_t>(n_) * n_handles_;
  require_memory(static_cast<double>(size) * (sizeof(double) + sizeof(int)),
                 "the weight of each handle at each vertex");
  weights_.resize(size);
  rows_.resize(size);
}

void HandleWeights::normalize() {
  for (int v = 0; v < n_; ++v) {
    const std::ptrdiff_t first = std::ptrdiff_t{v} * n_handles_;
    Eigen::Map<Eigen::VectorXd> weights(weights_.data() + first, n_handles_);
    if (const double sum = weights.sum(); sum > 0) weights /= sum;
  }
}

Positions HandleWeights::blend(const Positions& of_rows, const Workers& workers) const {
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

HandleWeights find_geodesic_weights(const EdgeGraph& graph, const HandleVertices& handles, int threads,
                                    const MeterPart& meter) {
  const int n = graph.n_vertices();
  const auto n_handles = static_cast<int>(handles.size());
  HandleWeights weights(n, n_handles);
  for_each_piece(threads, n_handles, [&](int h) {
    const Nearest nearest = find_nearest(graph, handles[h]);
    for (int v = 0; v < n; ++v)
      weights.set(v, h, 1 / std::max(kNearest, static_cast<double>(nearest.distance[v])), nearest.row[v]);
    meter.add(1.0 / n_handles);
  });
  weights.normalize();
  return weights;
}

HandleWeights find_harmonic_weights(const PreparedModel& model, const PreparedConstraints& constraints,
                                    const std::vector<int>& handle_of_row, int n_handles, double accuracy) {
  const auto n = static_cast<int>(model.rest.rows());
  const auto n_rows = static_cast<int>(handle_of_row.size());
  std::vector<int> first_row(n_handles);
  for (int k = n_rows - 1; k >= 0; --k) first_row[handle_of_row[k]] = k;
  HandleWeights weights(n, n_handles);
  // A solve has three right-hand sides.
  for (int first = 0; first < n_handles; first += 3) {
    Positions is_of_handle = Positions::Zero(n_rows, 3);
    for (int k = 0; k < n_rows; ++k)
      if (const int h = handle_of_row[k] - first; h >= 0 && h < 3) is_of_handle(k, h) = 1;
    const Positions values = interpolate_harmonically(model, constraints, is_of_handle, accuracy).values;
    for (int h = first; h < std::min(first + 3, n_handles); ++h)
      for (int v = 0; v < n; ++v) weights.set(v, h, values(v, h - first), first_row[h]);
  }
  return weights;
}

}  // namespace arap
