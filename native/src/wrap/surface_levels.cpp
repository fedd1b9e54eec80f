// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_levels.h"

#include <algorithm>
#include <utility>

#include "base/grouped.h"
#include "base/union_find.h"
#include "geometry/point_tree.h"

namespace arap {

namespace {

/// Parts of so few nodes are not made coarser: a gradient needs neighbours.
constexpr int kFewNodes = 24;
constexpr int kMostLevels = 24;

/// @param for_each  for_each(join) calls join(a, b) for all neighbours, in any order and as often as it likes
template <class ForEach>
void connect(SurfaceLevel& level, const ForEach& for_each) {
  const Grouped pairs(level.n_nodes(), [&](const auto& add) {
    for_each([&](int a, int b) {
      if (a == b) return;
      add(a, b);
      add(b, a);
    });
  });
  level.offsets.assign(1, 0);
  std::vector<int> around;
  for (int node = 0; node < level.n_nodes(); ++node) {
    around.assign(pairs.of(node).begin(), pairs.of(node).end());
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    level.neighbours.insert(level.neighbours.end(), around.begin(), around.end());
    level.offsets.push_back(static_cast<int>(level.neighbours.size()));
  }
}

std::vector<int> nodes_of_vertices(const PolygonMesh& surface, bool has_faces, int threads, SurfaceLevel& level) {
  const std::vector<int> same = surface.same_places(threads);
  // A loose vertex may be the first one of its place, so a place counts where any of its vertices has a face.
  std::vector<char> is_node(same.size(), 0);
  for (size_t v = 0; v < same.size(); ++v)
    if (!has_faces || surface.part_of_vertex()[v] >= 0) is_node[same[v]] = 1;
  std::vector<int> node(same.size(), -1);
  for (size_t v = 0; v < same.size(); ++v) {
    if (is_node[same[v]] == 0) continue;
    int& of_place = node[same[v]];
    // The vertex that stands for a place is one with a face: loose ones may be left behind.
    if (of_place < 0 && (!has_faces || surface.part_of_vertex()[v] >= 0)) {
      of_place = level.n_nodes();
      level.vertices.push_back(static_cast<int>(v));
    }
  }
  for (size_t v = 0; v < same.size(); ++v) node[v] = node[same[v]];
  return node;
}

void connect_by_faces(const PolygonMesh& surface, const std::vector<int>& node, SurfaceLevel& level) {
  connect(level, [&](const auto& join) {
    for (int f = 0; f < surface.n_faces(); ++f) {
      const std::span<const int> face = surface.face(f);
      for (size_t k = 0; k < face.size(); ++k) join(node[face[k]], node[face[k + 1 < face.size() ? k + 1 : 0]]);
    }
  });
}

void connect_near(SurfaceLevel& level) {
  constexpr int kNear = 7;  // with itself
  const PointTree tree(level.places);
  std::vector<PointTree::Near> found;
  std::vector<std::pair<int, int>> pairs;
  for (int node = 0; node < level.n_nodes(); ++node) {
    tree.nearest(level.places.row(node), kNear, found);
    for (const PointTree::Near& near : found) pairs.emplace_back(node, near.point);
  }
  connect(level, [&](const auto& join) {
    for (const auto& pair : pairs) join(pair.first, pair.second);
  });
}

Positions places_of(const std::vector<int>& vertices, const Positions& places) {
  Positions result(static_cast<Eigen::Index>(vertices.size()), 3);
  for (size_t k = 0; k < vertices.size(); ++k) result.row(static_cast<Eigen::Index>(k)) = places.row(vertices[k]);
  return result;
}

double mean_spacing(const SurfaceLevel& level) {
  double sum = 0;
  for (int node = 0; node < level.n_nodes(); ++node)
    for (const int other : level.around(node)) sum += (level.places.row(node) - level.places.row(other)).norm();
  return sum > 0 ? sum / static_cast<double>(level.neighbours.size()) : 1;
}

/// Of each node whether its part has few.
std::vector<char> in_small_parts(const SurfaceLevel& level) {
  UnionFind sets(level.n_nodes());
  for (int node = 0; node < level.n_nodes(); ++node)
    for (const int other : level.around(node)) sets.join(node, other);
  std::vector<int> count(level.n_nodes(), 0);
  for (int node = 0; node < level.n_nodes(); ++node) ++count[sets.find(node)];
  std::vector<char> result(level.n_nodes());
  for (int node = 0; node < level.n_nodes(); ++node) result[node] = count[sets.find(node)] <= kFewNodes ? 1 : 0;
  return result;
}

/// Takes nodes in their order that no earlier one is near to, along the surface. Every node gets the nearest of them.
/// @return  the nodes of `fine` that are taken; `coarser` of it becomes their numbers
std::vector<int> take_nodes(SurfaceLevel& fine, double radius) {
  const std::vector<char> is_kept = in_small_parts(fine);
  std::vector<int> taken;
  std::vector<double> distance(fine.n_nodes(), radius);
  std::vector<int> last_seen(fine.n_nodes(), -1);
  std::vector<int> waiting;
  fine.coarser.assign(fine.n_nodes(), -1);
  for (int node = 0; node < fine.n_nodes(); ++node) {
    if (fine.coarser[node] >= 0) continue;
    const auto number = static_cast<int>(taken.size());
    taken.push_back(node);
    fine.coarser[node] = number;
    distance[node] = 0;
    if (is_kept[node] != 0) continue;
    waiting.assign(1, node);
    while (!waiting.empty()) {
      const int next = waiting.back();
      waiting.pop_back();
      for (const int other : fine.around(next)) {
        const double away = (fine.places.row(other) - fine.places.row(node)).norm();
        if (last_seen[other] == number || !(away < radius)) continue;
        last_seen[other] = number;
        waiting.push_back(other);
        if (away >= distance[other]) continue;
        distance[other] = away;
        fine.coarser[other] = number;
      }
    }
  }
  return taken;
}

}  // namespace

SurfaceLevels::SurfaceLevels(const PolygonMesh& surface, const Positions& places, int threads, const MeterPart& meter) {
  const bool has_faces = surface.n_faces() > 0;
  SurfaceLevel level;
  node_of_vertex_ = nodes_of_vertices(surface, has_faces, threads, level);
  meter.add(.2);
  level.places = places_of(level.vertices, places);
  if (has_faces)
    connect_by_faces(surface, node_of_vertex_, level);
  else
    connect_near(level);
  spacing_ = mean_spacing(level);
  levels_.push_back(std::move(level));
  meter.add(.3);
  double left = .5;  // of the meter: each level is less work than the one before
  for (double radius = 2 * spacing_; size() < kMostLevels; radius *= 2) {
    SurfaceLevel& fine = levels_.back();
    const std::vector<int> taken = take_nodes(fine, radius);
    if (taken.size() == fine.vertices.size() && radius > 1) {
      fine.coarser.clear();
      break;
    }
    SurfaceLevel coarse;
    for (const int k : taken) coarse.vertices.push_back(fine.vertices[k]);
    coarse.places = places_of(coarse.vertices, places);
    connect(coarse, [&](const auto& join) {
      for (int k = 0; k < fine.n_nodes(); ++k)
        for (const int other : fine.around(k)) join(fine.coarser[k], fine.coarser[other]);
    });
    levels_.push_back(std::move(coarse));
    left /= 2;
    meter.add(left);
  }
  meter.add(left);
  if (size() == kMostLevels) levels_.back().coarser.clear();
}

}  // namespace arap
