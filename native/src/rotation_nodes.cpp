// SPDX-License-Identifier: GPL-3.0-or-later
#include "rotation_nodes.h"

#include <algorithm>
#include <span>
#include <utility>

#include "parallel.h"
#include "row_accumulator.h"

namespace arap {

namespace {

/// Support of a node's weights, in radii.
constexpr double kSupport = 2;
/// A vertex' own support is at least this part of it, squared: every node that covers a vertex is well inside.
constexpr double kLeastSupport = .5;

/// Chosen nodes, and how far the vertices are from the nearest.
class Sampler {
 public:
  Sampler(const SurfaceGraph& graph, double radius, const std::vector<int>& group)
      : graph_(graph),
        radius_(static_cast<float>(radius)),
        group_(group),
        distance_(graph.n_vertices(), static_cast<float>(radius)),
        is_chosen_(graph.n_vertices(), 0) {}

  [[nodiscard]] bool is_covered(int vertex) const { return distance_[vertex] < radius_; }

  void choose(int vertex) {
    if (is_chosen_[vertex] != 0) return;
    is_chosen_[vertex] = 1;
    nodes_.push_back(vertex);
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

  [[nodiscard]] std::vector<int> take_nodes() { return std::move(nodes_); }

 private:
  [[nodiscard]] bool is_same_group(int a, int b) const { return group_.empty() || group_[a] == group_[b]; }

  const SurfaceGraph& graph_;
  float radius_;
  const std::vector<int>& group_;
  std::vector<float> distance_;  ///< to the nearest node, at most the radius
  std::vector<char> is_chosen_;
  DistanceQueue queue_;
  std::vector<int> nodes_;
};

std::vector<int> choose_vertices(const SurfaceGraph& graph, double radius, const std::vector<std::vector<int>>& mirrors,
                                 const std::vector<int>& group) {
  Sampler sampler(graph, radius, group);
  std::vector<int> orbit;
  const auto choose_with_images = [&](int vertex) {
    orbit.assign(1, vertex);
    for (const std::vector<int>& mirror : mirrors)
      for (size_t k = 0, n = orbit.size(); k < n; ++k) orbit.push_back(mirror[orbit[k]]);
    for (const int image : orbit)
      if (!graph.arcs(image).empty()) sampler.choose(image);
  };
  const auto choose_where = [&](const auto& is_wanted) {
    for (int v = 0; v < graph.n_vertices(); ++v)
      if (!graph.arcs(v).empty() && !sampler.is_covered(v) && is_wanted(v)) choose_with_images(v);
  };
  // First on the planes of symmetry: a node beside one and its image would be very close.
  for (const std::vector<int>& mirror : mirrors) choose_where([&](int v) { return mirror[v] == v; });
  choose_where([](int) { return true; });
  return sampler.take_nodes();
}

struct Reached {
  int vertex;
  float weight;
};

/// s_j^2. The corners of a triangle share their weights, which spreads these: their mean squared distance from the
/// node, s_j^2 / 3 on a small triangle, is to be the same on a large one.
double own_support(double support, double spread) {
  const double whole = support * support;
  return std::max(whole - 3 * spread, kLeastSupport * whole);
}

/// The vertices in the support of each node.
std::vector<std::vector<Reached>> find_supports(const SurfaceGraph& graph, const std::vector<double>& spreads,
                                                const std::vector<int>& nodes, double radius, int threads) {
  std::vector<std::vector<Reached>> supports(nodes.size());
  const double support = kSupport * radius;
#pragma omp parallel num_threads(openmp_threads(threads))
  {
    DistanceSweep sweep(graph);
#pragma omp for schedule(dynamic, 8)
    for (size_t c = 0; c < nodes.size(); ++c)
      sweep.run(std::span(&nodes[c], 1), static_cast<float>(support), [&](int vertex, float distance) {
        const auto d = static_cast<double>(distance);
        const double weight = 1 - d * d / own_support(support, spreads[vertex]);
        if (weight > 0) supports[c].push_back({vertex, static_cast<float>(weight)});
      });
  }
  return supports;
}

}  // namespace

std::vector<double> face_spreads(const PolygonMesh& mesh) {
  std::vector<double> spreads(mesh.n_vertices(), 0);
  std::vector<int> n_faces(mesh.n_vertices(), 0);
  const Positions& p = mesh.positions();
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    const double share = 1 / static_cast<double>(face.size());
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (const int v : face) centre += share * p.row(v);
    double spread = 0;
    for (const int v : face) spread += share * (p.row(v) - centre).squaredNorm();
    for (const int v : face) {
      spreads[v] += spread;
      ++n_faces[v];
    }
  }
  for (size_t v = 0; v < spreads.size(); ++v) spreads[v] /= std::max(1, n_faces[v]);
  return spreads;
}

RotationNodes choose_rotation_nodes(const SurfaceGraph& graph, const std::vector<double>& spreads, double radius,
                                    const std::vector<std::vector<int>>& mirrors, const std::vector<int>& group,
                                    int threads) {
  RotationNodes result;
  result.vertices = choose_vertices(graph, radius, mirrors, group);
  const std::vector<std::vector<Reached>> supports = find_supports(graph, spreads, result.vertices, radius, threads);
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
      result.weights[slot] = static_cast<double>(reached.weight);
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

/// The nodes whose cells have a vertex, with their q there.
using NodeRow = RowAccumulator<Vector3>;

/// Fills the cells of nodes, vertex by vertex: consecutive vertices are a share.
class NodeCells {
 public:
  NodeCells(const CellEnergy& cells, const RotationNodes& nodes, int threads)
      : cells_(cells),
        nodes_(nodes),
        shares_(threads, cells.n_vertices()),
        node_at_(cells.n_vertices(), -1),
        next_(shares_.count(), std::vector<int>(nodes.size(), 0)) {
    for (int c = 0; c < nodes.size(); ++c) node_at_[nodes.vertices[c]] = c;
  }

  void fill(CellEnergy& result) {
    for_each_row([&](int share, int j, const NodeRow& row) {
      for (const auto& [node, q] : row.entries())
        if (node != node_at_[j]) ++next_[share][node];
    });
    place_shares(result);
    for_each_row([&](int share, int j, const NodeRow& row) {
      for (const auto& [node, q] : row.entries()) {
        const int slot = node == node_at_[j] ? result.cell_offsets[node] : next_[share][node]++;
        result.cell_vertices[slot] = j;
        result.q.row(slot) = q.transpose();
      }
    });
  }

 private:
  /// Counts of entries become places: in each cell its node, then the shares in order.
  void place_shares(CellEnergy& result) {
    result.cell_offsets.assign(1, 0);
    for (int c = 0; c < nodes_.size(); ++c) {
      int place = result.cell_offsets.back() + 1;
      for (std::vector<int>& next : next_) place += std::exchange(next[c], place);
      result.cell_offsets.push_back(place);
    }
    result.cell_vertices.resize(result.cell_offsets.back());
    result.q.resize(result.cell_offsets.back(), 3);
  }

  template <class Visit>
  void for_each_row(const Visit& visit) const {
    shares_.for_each([&](int share, int begin, int end) {
      NodeRow row(nodes_.size());
      for (int j = begin; j < end; ++j) {
        collect(j, row);
        visit(share, j, row);
        row.clear();
      }
    });
  }

  void collect(int j, NodeRow& row) const {
    for (int k = cells_.vertex_offsets[j]; k < cells_.vertex_offsets[j + 1]; ++k) {
      const int i = cells_.vertex_cells[k];
      const Vector3 q = cells_.q.row(cells_.vertex_incidences[k]).transpose();
      for (int e = nodes_.offsets[i]; e < nodes_.offsets[i + 1]; ++e) row[nodes_.nodes[e]] += nodes_.weights[e] * q;
    }
    if (node_at_[j] >= 0) row[node_at_[j]] += Vector3::Zero();  // in its own cell whatever else is
  }

  const CellEnergy& cells_;
  const RotationNodes& nodes_;
  Shares shares_;
  std::vector<int> node_at_;            ///< of each vertex, or -1
  std::vector<std::vector<int>> next_;  ///< of each share: entries of each cell, then where the next one goes
};

}  // namespace

CellEnergy share_rotations(const CellEnergy& cells, const RotationNodes& nodes, int threads) {
  CellEnergy result;
  result.K = cells.K;
  result.rest_energy = cells.rest_energy;
  NodeCells(cells, nodes, threads).fill(result);
  result.index_by_vertex();
  return result;
}

}  // namespace arap
