// SPDX-License-Identifier: GPL-3.0-or-later
#include "rotation_nodes.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <span>
#include <utility>

#include "parallel.h"

namespace arap {

namespace {

/// Support of a node's weights, in radii.
constexpr double kSupport = 2;
/// A node's share of the surface is at least this part of r^2, so that faces without area have rotations too.
constexpr double kLeastShare = .01;
/// A vertex' own support is at least this part of it, squared: every node that covers a vertex is well inside.
constexpr double kLeastSupport = .5;

struct ChosenNodes {
  std::vector<int> vertices;  ///< of each node
  std::vector<int> nearest;   ///< the node nearest to each vertex; -1 for a loose one
};

/// Chosen nodes, and which is the nearest to each vertex, and how far.
class Sampler {
 public:
  Sampler(const SurfaceGraph& graph, double radius, const std::vector<int>& group)
      : graph_(graph),
        radius_(static_cast<float>(radius)),
        group_(group),
        distance_(graph.n_vertices(), static_cast<float>(radius)),
        nearest_(graph.n_vertices(), -1),
        is_chosen_(graph.n_vertices(), 0) {}

  [[nodiscard]] bool is_covered(int vertex) const { return distance_[vertex] < radius_; }

  void choose(int vertex) {
    if (is_chosen_[vertex] != 0) return;
    const auto node = static_cast<int>(nodes_.size());
    is_chosen_[vertex] = 1;
    nodes_.push_back(vertex);
    distance_[vertex] = 0;
    nearest_[vertex] = node;
    queue_.push({0, vertex});
    while (!queue_.empty()) {
      const auto [distance, near] = queue_.pop();
      if (distance > distance_[near]) continue;
      for (const SurfaceGraph::Arc& arc : graph_.arcs(near)) {
        const float further = distance + arc.length;
        if (further >= distance_[arc.vertex] || !is_same_group(vertex, arc.vertex)) continue;
        distance_[arc.vertex] = further;
        nearest_[arc.vertex] = node;
        queue_.push({further, arc.vertex});
      }
    }
  }

  [[nodiscard]] ChosenNodes take() { return {.vertices = std::move(nodes_), .nearest = std::move(nearest_)}; }

 private:
  [[nodiscard]] bool is_same_group(int a, int b) const { return group_.empty() || group_[a] == group_[b]; }

  const SurfaceGraph& graph_;
  float radius_;
  const std::vector<int>& group_;
  std::vector<float> distance_;  ///< to the nearest node, at most the radius
  std::vector<int> nearest_;     ///< which that is
  std::vector<char> is_chosen_;
  DistanceQueue queue_;
  std::vector<int> nodes_;
};

ChosenNodes choose_vertices(const SurfaceGraph& graph, double radius, const std::vector<std::vector<int>>& mirrors,
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
  return sampler.take();
}

/// What each node stands for: the area of the surface that no other node is nearer to.
std::vector<double> node_shares(const ChosenNodes& nodes, const std::vector<double>& areas, double radius,
                                const std::vector<std::vector<int>>& mirrors) {
  std::vector<double> shares(nodes.vertices.size(), 0);
  for (size_t v = 0; v < areas.size(); ++v)
    if (nodes.nearest[v] >= 0) shares[nodes.nearest[v]] += areas[v];
  // A vertex as near to two nodes counts for the one that was chosen first, which need not be so for its image.
  for (const std::vector<int>& mirror : mirrors)
    for (int c = 0; c < static_cast<int>(shares.size()); ++c)
      if (const int image = nodes.nearest[mirror[nodes.vertices[c]]]; image > c)
        shares[c] = shares[image] = (shares[c] + shares[image]) / 2;
  for (double& share : shares) share = std::max(share, kLeastShare * radius * radius);
  return shares;
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
  std::atomic<size_t> next = 0;
  for_each_piece(threads, threads, [&](int /*thread*/) {
    DistanceSweep sweep(graph);
    std::vector<Reached> reached;
    for (size_t c = next++; c < nodes.size(); c = next++) {
      reached.clear();
      sweep.run(std::span(&nodes[c], 1), static_cast<float>(support), [&](int vertex, float distance) {
        const auto d = static_cast<double>(distance);
        const double weight = 1 - d * d / own_support(support, spreads[vertex]);
        if (weight > 0) reached.push_back({vertex, static_cast<float>(weight)});
      });
      supports[c] = reached;
    }
  });
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

RotationNodes choose_rotation_nodes(const SurfaceGraph& graph, const std::vector<double>& spreads,
                                    const std::vector<double>& areas, double radius,
                                    const std::vector<std::vector<int>>& mirrors, const std::vector<int>& group,
                                    int threads) {
  RotationNodes result;
  ChosenNodes chosen = choose_vertices(graph, radius, mirrors, group);
  const std::vector<double> shares = node_shares(chosen, areas, radius, mirrors);
  result.vertices = std::move(chosen.vertices);
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
      result.weights[slot] = shares[c] * static_cast<double>(reached.weight);
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

RotationNodes node_at_each_vertex(int n_vertices) {
  RotationNodes result;
  result.vertices.resize(n_vertices);
  std::iota(result.vertices.begin(), result.vertices.end(), 0);
  result.nodes = result.vertices;
  result.offsets = result.vertices;
  result.offsets.push_back(n_vertices);
  result.weights.assign(n_vertices, 1.0);
  return result;
}

}  // namespace arap
