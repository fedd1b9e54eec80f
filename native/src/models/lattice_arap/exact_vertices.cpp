// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/exact_vertices.h"

#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <set>
#include <span>
#include <tuple>

#include "base/eigen_compat.h"
#include "base/grouped.h"
#include "geometry/rotation.h"

namespace arap {

namespace {

/// Nothing pulls a loose vertex from its target.
bool is_exact(const PolygonMesh& mesh, const ConstraintSet& set, size_t k) {
  return set.strengths.empty() || set.strengths[k] >= 1 - 1e-9 ||
         (mesh.part_of_vertex()[set.vertices[k]] < 0 && set.strengths[k] > 0);
}

/// The vertices that each has an edge to, once for each side of a face.
Grouped neighbours_of(const PolygonMesh& mesh) {
  return {mesh.n_vertices(), [&](const auto& add) {
            for (int f = 0; f < mesh.n_faces(); ++f) {
              const std::span<const int> face = mesh.face(f);
              for (size_t k = 0; k < face.size(); ++k) {
                const int next = face[(k + 1) % face.size()];
                add(face[k], next);
                add(next, face[k]);
              }
            }
          }};
}

Matrix3 covariance(const Positions& from, const Positions& to) {
  return (to.rowwise() - to.colwise().mean()).transpose() * (from.rowwise() - from.colwise().mean());
}

}  // namespace

ExactVertices::ExactVertices(const PolygonMesh& mesh, const ConstraintSet& set, const std::vector<int>& pieces,
                             const std::vector<int>& rigid_regions, const std::vector<char>& at_rest, double reach) {
  find_places(mesh, set, rigid_regions, at_rest);
  find_followers(mesh, reach);
  find_patches(set, pieces);
  std::vector<char> stays = at_rest;
  for (const Region& region : regions_)
    for (const int v : region.carried) stays[mesh.part_of_vertex()[v]] = 0;
  for (int part = 0; part < mesh.n_parts(); ++part)
    if (stays[part] != 0) parts_at_rest_.push_back(part);
}

void ExactVertices::find_places(const PolygonMesh& mesh, const ConstraintSet& set,
                                const std::vector<int>& rigid_regions, const std::vector<char>& at_rest) {
  std::map<int, int> place_of_vertex;
  for (size_t k = 0; k < set.vertices.size(); ++k) {
    if (!is_exact(mesh, set, k)) continue;
    const auto [found, is_new] = place_of_vertex.emplace(set.vertices[k], static_cast<int>(hard_.size()));
    if (is_new) hard_.push_back({set.vertices[k], {}});
    hard_[found->second].targets.push_back(static_cast<int>(k));
  }
  for (const Hard& hard : hard_) vertices_.push_back(hard.vertex);
  std::map<int, std::vector<int>> members;
  for (size_t v = 0; v < rigid_regions.size(); ++v)
    if (rigid_regions[v] >= 0 && mesh.part_of_vertex()[v] >= 0)
      members[rigid_regions[v]].push_back(static_cast<int>(v));
  for (auto& [number, of_region] : members) {
    if (of_region.size() == 1) continue;  // it is no more rigid than it is alone
    Region region{mesh.positions()(of_region, all), of_region, {}, {}, {}, {}};
    find_parts(mesh, at_rest, region);
    for (size_t k = 0; k < of_region.size(); ++k)
      if (const auto found = place_of_vertex.find(of_region[k]); found != place_of_vertex.end())
        region.hard.emplace_back(static_cast<int>(k), found->second);
    vertices_.insert(vertices_.end(), of_region.begin(), of_region.end());
    regions_.push_back(std::move(region));
  }
}

void ExactVertices::find_parts(const PolygonMesh& mesh, const std::vector<char>& at_rest, Region& region) {
  std::set<int> carried;
  for (size_t k = 0; k < region.members.size(); ++k)
    if (const int part = mesh.part_of_vertex()[region.members[k]]; at_rest[part] != 0)
      carried.insert(part);
    else
      region.moved.push_back(static_cast<int>(k));
  if (region.moved.empty()) {
    region.moved.resize(region.members.size());
    std::iota(region.moved.begin(), region.moved.end(), 0);
    return;
  }
  if (carried.empty()) return;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (carried.contains(mesh.part_of_vertex()[v])) region.carried.push_back(v);
  region.rest_of_carried = mesh.positions()(region.carried, all);
}

void ExactVertices::find_followers(const PolygonMesh& mesh, double reach) {
  // Dijkstra's algorithm from all of them.
  struct Reached {
    double distance;
    int vertex;
    int place;
    bool operator>(const Reached& other) const {
      return std::tie(distance, vertex, place) > std::tie(other.distance, other.vertex, other.place);
    }
  };
  const Grouped neighbours = neighbours_of(mesh);
  std::vector<char> is_done(mesh.n_vertices(), 0);
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  const auto go_on = [&](const Reached& from) {
    for (const int v : neighbours.of(from.vertex)) {
      const double distance = from.distance + (mesh.positions().row(v) - mesh.positions().row(from.vertex)).norm();
      if (is_done[v] == 0 && distance < reach) queue.push({distance, v, from.place});
    }
  };
  for (const int v : vertices_) is_done[v] = 1;
  for (size_t k = 0; k < vertices_.size(); ++k) go_on({0, vertices_[k], static_cast<int>(k)});
  while (!queue.empty()) {
    const Reached next = queue.top();
    queue.pop();
    if (is_done[next.vertex] != 0) continue;
    is_done[next.vertex] = 1;
    const double part = next.distance / reach;
    followers_.push_back({next.vertex, next.place, (1 - part * part) * (1 - part * part)});
    go_on(next);
  }
}

void ExactVertices::find_patches(const ConstraintSet& set, const std::vector<int>& pieces) {
  for (int p = 0; p < set.patches.size(); ++p) {
    LinearRow average = average_of(set.patches, p, [&](int v) { return pieces[v] >= 0; });
    if (average.indices.empty()) continue;
    patches_.add(std::move(average), 1);
    patch_targets_.push_back(static_cast<int>(set.vertices.size()) + p);
  }
  std::vector<char> is_fixed(pieces.size(), 0);
  for (const int v : vertices_) is_fixed[v] = 1;
  of_patches_ = SmallestChange(patches_, is_fixed);
}

void ExactVertices::apply(const Positions& targets, const Workers& workers, Positions& points) const {
  Positions places(vertices_.size(), 3);
  for (size_t k = 0; k < hard_.size(); ++k) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (const int t : hard_[k].targets) sum += targets.row(t);
    places.row(static_cast<Eigen::Index>(k)) = sum / static_cast<double>(hard_[k].targets.size());
  }
  auto next = static_cast<Eigen::Index>(hard_.size());
  for (const Region& region : regions_) {
    const Positions rest = region.rest(region.moved, all);
    Positions reached(rest.rows(), 3);
    for (size_t k = 0; k < region.moved.size(); ++k)
      reached.row(static_cast<Eigen::Index>(k)) = points.row(region.members[region.moved[k]]);
    Eigen::RowVector3d from = rest.colwise().mean();
    Eigen::RowVector3d to = reached.colwise().mean();
    Matrix3 turns = covariance(rest, reached);
    if (!region.hard.empty()) {
      constexpr double kShareOfLattice = 1e-9;
      Positions rest_of_hard(region.hard.size(), 3);
      Positions of_hard(region.hard.size(), 3);
      for (size_t k = 0; k < region.hard.size(); ++k) {
        rest_of_hard.row(static_cast<Eigen::Index>(k)) = region.rest.row(region.hard[k].first);
        of_hard.row(static_cast<Eigen::Index>(k)) = places.row(region.hard[k].second);
      }
      from = rest_of_hard.colwise().mean();
      to = of_hard.colwise().mean();
      turns = covariance(rest_of_hard, of_hard) + kShareOfLattice * turns;
    }
    const Matrix3 turn = nearest_rotation(turns, Matrix3::Identity());
    const auto n = static_cast<Eigen::Index>(region.members.size());
    places.middleRows(next, n) = ((region.rest.rowwise() - from) * turn.transpose()).rowwise() + to;
    points(region.carried, all) = ((region.rest_of_carried.rowwise() - from) * turn.transpose()).rowwise() + to;
    // A hard vertex is where its region is.
    for (const auto& [member, place] : region.hard) places.row(place) = places.row(next + member);
    next += n;
  }
  const Positions left = places - points(vertices_, all);
  for (size_t k = 0; k < vertices_.size(); ++k) points.row(vertices_[k]) = places.row(static_cast<Eigen::Index>(k));
  for (const Follower& follower : followers_) points.row(follower.vertex) += follower.share * left.row(follower.place);
  Positions gaps = targets(patch_targets_, all);
  for (int p = 0; p < patches_.size(); ++p) gaps.row(p) -= patches_.rows[p].of(points);
  of_patches_.close(gaps, points, workers);
}

}  // namespace arap
