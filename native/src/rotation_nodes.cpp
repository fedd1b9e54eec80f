// SPDX-License-Identifier: GPL-3.0-or-later
#include "rotation_nodes.h"

#include <algorithm>
#include <span>
#include <utility>

#include "parallel.h"

namespace arap {

namespace {

/// Support of a node's weights, in radii.
constexpr double kSupport = 2;

/// Chosen nodes, and how far the vertices are from the nearest.
class Sampler {
 public:
  Sampler(const SurfaceGraph& graph, double radius, const std::vector<int>& group)
      : graph_(graph),
        radius_(static_cast<float>(radius)),
        group_(group),
        distance_(graph.n_vertices(), static_cast<float>(radius)) {}

  [[nodiscard]] bool is_covered(int vertex) const { return distance_[vertex] < radius_; }
  [[nodiscard]] bool is_node(int vertex) const { return distance_[vertex] == 0 && is_chosen_[vertex] != 0; }

  void choose(int vertex) {
    if (is_chosen_.empty()) is_chosen_.assign(graph_.n_vertices(), 0);
    if (is_chosen_[vertex] != 0) return;
    is_chosen_[vertex] = 1;
    nodes.push_back(vertex);
    distance_[vertex] = 0;
    queue_.push({0, vertex});
    while (!queue_.empty()) {
      const auto [distance, near] = queue_.pop();
      if (distance > distance_[near]) continue;
      for (const SurfaceGraph::Arc& arc : graph_.arcs(near)) {
        const float further = distance + arc.length;
        if (further >= distance_[arc.vertex] || !is_same_group(vertex, arc.vertex)) continue;
        distance_[arc.vertex] = further;
        queue_.push({further, arc.vertex});
      }
    }
  }

  std::vector<int> nodes;

 private:
  [[nodiscard]] bool is_same_group(int a, int b) const { return group_.empty() || group_[a] == group_[b]; }

  const SurfaceGraph& graph_;
  float radius_;
  const std::vector<int>& group_;
  std::vector<float> distance_;  ///< to the nearest node, at most the radius
  std::vector<char> is_chosen_;
  DistanceQueue queue_;
};

std::vector<int> choose_vertices(const SurfaceGraph& graph, double radius, const std::vector<std::vector<int>>& mirrors,
                                 const std::vector<int>& group) {
  Sampler sampler(graph, radius, group);
  std::vector<int> orbit;
  const auto choose_with_images = [&](int vertex) {
    orbit.assign(1, vertex);
    for (const std::vector<int>& mirror : mirrors)
      for (size_t k = 0, n = orbit.size(); k < n; ++k) orbit.push_back(mirror[orbit[k]]);
    for (const int image : orbit) sampler.choose(image);
  };
  const auto choose_where = [&](const auto& is_wanted) {
    for (int v = 0; v < graph.n_vertices(); ++v)
      if (!graph.arcs(v).empty() && !sampler.is_covered(v) && is_wanted(v)) choose_with_images(v);
  };
  // First on the planes of symmetry: a node beside one and its image would be very close.
  for (const std::vector<int>& mirror : mirrors) choose_where([&](int v) { return mirror[v] == v; });
  choose_where([](int) { return true; });
  return std::move(sampler.nodes);
}

struct Reached {
  int vertex;
  float weight;
};

/// The vertices in the support of each node.
std::vector<std::vector<Reached>> find_supports(const SurfaceGraph& graph, const std::vector<int>& nodes, double radius,
                                                int threads) {
  std::vector<std::vector<Reached>> supports(nodes.size());
  const double support = kSupport * radius;
#pragma omp parallel num_threads(threads)
  {
    DistanceSweep sweep(graph);
#pragma omp for schedule(dynamic, 8)
    for (size_t c = 0; c < nodes.size(); ++c)
      sweep.run(std::span(&nodes[c], 1), static_cast<float>(support), [&](int vertex, float distance) {
        supports[c].push_back({vertex, static_cast<float>(faded(distance, support))});
      });
  }
  return supports;
}

}  // namespace

RotationNodes choose_rotation_nodes(const SurfaceGraph& graph, double radius,
                                    const std::vector<std::vector<int>>& mirrors, const std::vector<int>& group,
                                    int threads) {
  RotationNodes result;
  result.vertices = choose_vertices(graph, radius, mirrors, group);
  const std::vector<std::vector<Reached>> supports = find_supports(graph, result.vertices, radius, threads);
  result.offsets.assign(graph.n_vertices() + 1, 0);
  for (const std::vector<Reached>& support : supports)
    for (const Reached& reached : support) ++result.offsets[reached.vertex + 1];
  for (size_t v = 1; v < result.offsets.size(); ++v) result.offsets[v] += result.offsets[v - 1];
  result.nodes.resize(result.offsets.back());
  result.weights.resize(result.offsets.back());
  std::vector<int> next(result.offsets.begin(), result.offsets.end() - 1);
  for (size_t c = 0; c < supports.size(); ++c)
    for (const Reached& reached : supports[c]) {
      const int slot = next[reached.vertex]++;
      result.nodes[slot] = static_cast<int>(c);
      result.weights[slot] = reached.weight;
    }
  parallel_for(threads, graph.n_vertices(), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      double sum = 0;
      for (int k = result.offsets[v]; k < result.offsets[v + 1]; ++k) sum += result.weights[k];
      for (int k = result.offsets[v]; k < result.offsets[v + 1]; ++k) result.weights[k] /= sum;
    }
  });
  return result;
}

namespace {

/// q of the nodes at one vertex.
class BlendedRow {
 public:
  explicit BlendedRow(int n_nodes) : slot_(n_nodes, -1) {}

  void add(int node, const Vector3& value) {
    int& slot = slot_[node];
    if (slot < 0) {
      slot = static_cast<int>(entries.size());
      entries.emplace_back(node, Vector3::Zero());
    }
    entries[slot].second += value;
  }

  void clear() {
    for (const auto& entry : entries) slot_[entry.first] = -1;
    entries.clear();
  }

  std::vector<std::pair<int, Vector3>> entries;

 private:
  std::vector<int> slot_;
};

}  // namespace

CellEnergy share_rotations(const CellEnergy& cells, const RotationNodes& nodes, int threads) {
  const int n = cells.n_vertices();
  const int n_pieces = std::clamp(threads, 1, n / 4096 + 1);
  std::vector<std::vector<std::pair<int, Vector3>>> pieces(n_pieces);
  std::vector<int> row_sizes(n);
  std::vector<int> node_at(n, -1);
  for (int c = 0; c < nodes.size(); ++c) node_at[nodes.vertices[c]] = c;
  const auto start = [&](int piece) { return static_cast<int>(static_cast<int64_t>(n) * piece / n_pieces); };
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int p = 0; p < n_pieces; ++p) {
    BlendedRow row(nodes.size());
    for (int j = start(p); j < start(p + 1); ++j) {
      for (int k = cells.vertex_offsets[j]; k < cells.vertex_offsets[j + 1]; ++k) {
        const int i = cells.vertex_cells[k];
        const Vector3 q = cells.q.row(cells.vertex_incidences[k]).transpose();
        for (int e = nodes.offsets[i]; e < nodes.offsets[i + 1]; ++e) row.add(nodes.nodes[e], nodes.weights[e] * q);
      }
      if (node_at[j] >= 0) row.add(node_at[j], Vector3::Zero());  // in its cell whatever else is
      row_sizes[j] = static_cast<int>(row.entries.size());
      pieces[p].insert(pieces[p].end(), row.entries.begin(), row.entries.end());
      row.clear();
    }
  }

  CellEnergy result;
  result.K = cells.K;
  result.rest_energy = cells.rest_energy;
  result.cell_offsets.assign(nodes.size() + 1, 0);
  for (const auto& piece : pieces)
    for (const auto& entry : piece) ++result.cell_offsets[entry.first + 1];
  for (size_t c = 1; c < result.cell_offsets.size(); ++c) result.cell_offsets[c] += result.cell_offsets[c - 1];
  result.cell_vertices.resize(result.cell_offsets.back());
  result.q.resize(result.cell_offsets.back(), 3);
  // The node's own vertex comes first.
  std::vector<int> next(result.cell_offsets.begin(), result.cell_offsets.end() - 1);
  for (int& slot : next) ++slot;
  for (int p = 0; p < n_pieces; ++p) {
    auto entry = pieces[p].begin();
    for (int j = start(p); j < start(p + 1); ++j)
      for (int k = 0; k < row_sizes[j]; ++k, ++entry) {
        const int c = entry->first;
        const int slot = j == nodes.vertices[c] ? result.cell_offsets[c] : next[c]++;
        result.cell_vertices[slot] = j;
        result.q.row(slot) = entry->second.transpose();
      }
  }
  result.index_by_vertex();
  return result;
}

}  // namespace arap
