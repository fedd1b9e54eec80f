// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/node_choice.h"

#include <algorithm>
#include <utility>

namespace arap {

namespace {

/// A node moves by less than this part of r. Vertices are nearer than r to a node before it moves, and than 1.4 r
/// after: well inside of every vertex' own support, which is at least sqrt(2) r.
constexpr double kFurthestMove = .4;

/// A vertex and its images at all combinations of planes, in the same order for each vertex.
std::vector<int> images_of(int vertex, const std::vector<std::vector<int>>& mirrors) {
  std::vector<int> images(1, vertex);
  for (const std::vector<int>& mirror : mirrors)
    for (size_t k = 0, n = images.size(); k < n; ++k) images.push_back(mirror[images[k]]);
  return images;
}

/// Chosen nodes, and which is the nearest to each vertex, and how far.
class Sampler {
 public:
  Sampler(const SurfaceGraph& graph, double radius, const std::vector<int>& group)
      : graph_(graph),
        radius_(static_cast<float>(radius)),
        group_(group),
        distance_(graph.n_vertices(), static_cast<float>(radius)),
        nearest_(graph.n_vertices(), -1) {}

  [[nodiscard]] bool is_covered(int vertex) const { return distance_[vertex] < radius_; }
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }
  /// The nearest to a vertex; -1 at a loose one.
  [[nodiscard]] int nearest(int vertex) const { return nearest_[vertex]; }
  [[nodiscard]] double distance(int vertex) const { return static_cast<double>(distance_[vertex]); }

  void choose(int vertex) {
    if (is_node(vertex)) return;
    const auto node = static_cast<int>(nodes_.size());
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

 private:
  /// Nothing is nearer to a node than itself.
  [[nodiscard]] bool is_node(int vertex) const { return nearest_[vertex] >= 0 && nodes_[nearest_[vertex]] == vertex; }
  [[nodiscard]] bool is_same_group(int a, int b) const { return group_.empty() || group_[a] == group_[b]; }

  const SurfaceGraph& graph_;
  float radius_;
  const std::vector<int>& group_;
  std::vector<float> distance_;  ///< to the nearest node, at most the radius
  std::vector<int> nearest_;     ///< which that is
  DistanceQueue queue_;
  std::vector<int> nodes_;
};

Sampler choose_greedily(const SurfaceGraph& graph, double radius, const std::vector<std::vector<int>>& mirrors,
                        const std::vector<int>& group) {
  Sampler sampler(graph, radius, group);
  const auto choose_where = [&](const auto& is_wanted) {
    for (int v = 0; v < graph.n_vertices(); ++v)
      if (!graph.arcs(v).empty() && !sampler.is_covered(v) && is_wanted(v))
        for (const int image : images_of(v, mirrors))
          if (!graph.arcs(image).empty()) sampler.choose(image);
  };
  // First on the planes of symmetry: a node beside one and its image would be very close.
  for (const std::vector<int>& mirror : mirrors) choose_where([&](int v) { return mirror[v] == v; });
  choose_where([](int) { return true; });
  return sampler;
}

/// The area of the surface that is nearest to each node.
std::vector<double> nearest_areas(const Sampler& sampler, const std::vector<double>& areas,
                                  const std::vector<std::vector<int>>& mirrors) {
  std::vector<double> sums(sampler.nodes().size(), 0);
  for (int v = 0; v < static_cast<int>(areas.size()); ++v)
    if (sampler.nearest(v) >= 0) sums[sampler.nearest(v)] += areas[v];
  // A vertex as near to two nodes counts for the one that was chosen first, which need not be so for its image.
  for (const std::vector<int>& mirror : mirrors)
    for (int c = 0; c < static_cast<int>(sums.size()); ++c)
      if (const int image = sampler.nearest(mirror[sampler.nodes()[c]]); image > c)
        sums[c] = sums[image] = (sums[c] + sums[image]) / 2;
  return sums;
}

/// The centre of the area that is nearest to each node.
std::vector<Vector3> area_centres(const Sampler& sampler, const Positions& rest, const std::vector<double>& areas) {
  std::vector<Vector3> centres(sampler.nodes().size(), Vector3::Zero());
  std::vector<double> sums(centres.size(), 0);
  for (int v = 0; v < static_cast<int>(areas.size()); ++v)
    if (const int c = sampler.nearest(v); c >= 0) {
      centres[c] += areas[v] * rest.row(v).transpose();
      sums[c] += areas[v];
    }
  for (size_t c = 0; c < centres.size(); ++c)
    centres[c] = sums[c] > 0 ? Vector3(centres[c] / sums[c]) : Vector3(rest.row(sampler.nodes()[c]).transpose());
  return centres;
}

/// May node c move to the vertex, and its images to that one's? They stay in their areas and on their planes.
bool can_move(const Sampler& sampler, const std::vector<int>& images_of_node, const std::vector<int>& images,
              double furthest) {
  for (size_t k = 0; k < images.size(); ++k) {
    const bool is_in_area = sampler.nearest(images[k]) == sampler.nearest(images_of_node[k]);
    if (!is_in_area || sampler.distance(images[k]) >= furthest) return false;
    if (images_of_node[k] == images_of_node[0] && images[k] != images[0]) return false;
  }
  return true;
}

/// Where each node is after a step of Lloyd's: at the vertex nearest to the centre of its area.
std::vector<int> move_to_centres(const Sampler& sampler, const Positions& rest, const std::vector<double>& areas,
                                 double radius, const std::vector<std::vector<int>>& mirrors) {
  const std::vector<Vector3> centres = area_centres(sampler, rest, areas);
  const auto off_centre = [&](int v) { return (rest.row(v).transpose() - centres[sampler.nearest(v)]).squaredNorm(); };
  std::vector<int> moved = sampler.nodes();
  const double furthest = kFurthestMove * radius;
  for (int v = 0; v < static_cast<int>(areas.size()); ++v) {
    const int c = sampler.nearest(v);
    if (c < 0 || sampler.distance(v) >= furthest || off_centre(v) >= off_centre(moved[c])) continue;
    if (can_move(sampler, images_of(sampler.nodes()[c], mirrors), images_of(v, mirrors), furthest)) moved[c] = v;
  }
  // Centres of images are not always images, where a vertex is as near to two nodes: the first one leads.
  for (int c = 0; c < static_cast<int>(moved.size()); ++c) {
    const std::vector<int> nodes = images_of(sampler.nodes()[c], mirrors);
    const std::vector<int> images = images_of(moved[c], mirrors);
    for (size_t k = 1; k < nodes.size(); ++k)
      if (const int image = sampler.nearest(nodes[k]); image > c) moved[image] = images[k];
  }
  return moved;
}

}  // namespace

ChosenNodes choose_nodes(const SurfaceGraph& graph, const Positions& rest, const std::vector<double>& areas,
                         double radius, const std::vector<std::vector<int>>& mirrors, const std::vector<int>& group) {
  const Sampler sampler = choose_greedily(graph, radius, mirrors, group);
  return {.vertices = move_to_centres(sampler, rest, areas, radius, mirrors),
          .areas = nearest_areas(sampler, areas, mirrors)};
}

}  // namespace arap
