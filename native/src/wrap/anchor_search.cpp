// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/anchor_search.h"

#include <algorithm>
#include <cmath>

#include "parallel/parallel.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// Distance of a point from the surface over the distance of its anchors.
constexpr double kDistancePerSpacing = 2;
/// The outermost anchors weigh next to nothing, so the choice between them is not seen.
constexpr double kBeyondFarthest = 1.01;

/// Finds the anchors of one point after another. A thread has its own.
class Search {
 public:
  Search(const SurfaceLevels& levels, const PointTree& nearest, int n_anchors)
      : levels_(levels), nearest_(nearest), n_anchors_(static_cast<size_t>(n_anchors)) {
    last_seen_.reserve(levels.size());
    for (int l = 0; l < levels.size(); ++l) last_seen_.emplace_back(levels.level(l).n_nodes(), -1);
  }

  void add_anchors(int point, const Row& place, AnchorLists& lists) {
    const size_t before = lists.anchors.size();
    constexpr double kSlack = 1.1;
    constexpr double kNear = 8;  // mean edges: from there on, nearly the nearest will do, as anchors are coarse
    nearest_.nearest(place, 1, found_, kSlack);
    if (found_[0].squared < std::pow(kNear * levels_.spacing(), 2)) nearest_.nearest(place, 1, found_);
    const double spacings = std::sqrt(found_[0].squared) / (levels_.spacing() * kDistancePerSpacing);
    const double depth = std::clamp(std::log2(std::max(spacings, 1.)), 0., levels_.size() - 1.);
    const double fine = std::floor(depth);
    const double t = depth - fine;
    const double coarse_share = t * t * (3 - 2 * t);
    const auto level = static_cast<int>(fine);
    int node = found_[0].point;
    lists.nearest.push_back(node);
    for (int l = 0; l < level; ++l) node = levels_.level(l).coarser[node];
    add_of_level(point, place, level, node, 1 - coarse_share, lists);
    if (coarse_share > 0)
      add_of_level(point, place, level + 1, levels_.level(level).coarser[node], coarse_share, lists);
    lists.counts.push_back(static_cast<int>(lists.anchors.size() - before));
  }

 private:
  struct Candidate {
    double squared;  ///< distance
    int node;

    bool operator<(const Candidate& other) const {
      return squared != other.squared ? squared > other.squared : node > other.node;
    }
  };

  static double squared_distance(const SurfaceLevel& level, int node, const Row& place) {
    return (level.places.row(node) - place).squaredNorm();
  }

  /// Goes to neighbours as long as they are nearer.
  static int descend(const SurfaceLevel& level, int node, const Row& place) {
    double least = squared_distance(level, node, place);
    for (bool has_moved = true; has_moved;) {
      has_moved = false;
      for (const int other : level.around(node)) {
        const double squared = squared_distance(level, other, place);
        if (squared >= least) continue;
        least = squared;
        node = other;
        has_moved = true;
      }
    }
    return node;
  }

  /// The nearest nodes that are connected with `start` through such: one more than anchors, if there is.
  void grow(int point, const SurfaceLevel& level, std::vector<int>& last_seen, int start, const Row& place) {
    chosen_.clear();
    heap_.clear();
    const auto push = [&](int node) {
      if (last_seen[node] == point) return;
      last_seen[node] = point;
      heap_.push_back({squared_distance(level, node, place), node});
      std::push_heap(heap_.begin(), heap_.end());
    };
    push(start);
    while (!heap_.empty() && chosen_.size() <= n_anchors_) {
      std::pop_heap(heap_.begin(), heap_.end());
      chosen_.push_back(heap_.back());
      heap_.pop_back();
      for (const int other : level.around(chosen_.back().node)) push(other);
    }
  }

  /// @param share  the sum of the weights
  void add_of_level(int point, const Row& place, int l, int node, double share, AnchorLists& lists) {
    const SurfaceLevel& level = levels_.level(l);
    grow(point, level, last_seen_[l], descend(level, node, place), place);
    std::sort(chosen_.begin(), chosen_.end(), [](const Candidate& a, const Candidate& b) { return b < a; });
    const double R = kBeyondFarthest * std::sqrt(chosen_.back().squared);
    if (chosen_.size() > n_anchors_) chosen_.pop_back();
    // So near to a vertex it has all the weight.
    constexpr double kNearest = 1e-9;
    double sum = 0;
    const size_t first = lists.anchors.size();
    for (const Candidate& anchor : chosen_) {
      const double d = std::max(std::sqrt(anchor.squared), kNearest * R);
      const double root = R > 0 ? (R - d) / (R * d) * R : 1;
      lists.anchors.push_back({l, anchor.node, root * root});
      sum += root * root;
    }
    for (size_t k = first; k < lists.anchors.size(); ++k) lists.anchors[k].weight *= share / sum;
  }

  const SurfaceLevels& levels_;
  const PointTree& nearest_;
  size_t n_anchors_;
  std::vector<std::vector<int>> last_seen_;  ///< of each level and node: the last point that it was looked at for
  std::vector<PointTree::Near> found_;
  std::vector<Candidate> heap_;
  std::vector<Candidate> chosen_;
};

}  // namespace

std::vector<AnchorLists> find_anchors(const SurfaceLevels& levels, const PointTree& tree, const Positions& points,
                                      int n_anchors, int threads, const MeterPart& meter) {
  const auto n = static_cast<int>(points.rows());
  const Shares shares(threads, n);
  std::vector<AnchorLists> lists(shares.count());
  shares.for_each([&](int share, int begin, int end) {
    Search search(levels, tree, n_anchors);
    for (int p = begin; p < end; ++p) {
      search.add_anchors(p, points.row(p), lists[share]);
      constexpr int kTold = 512;
      if ((p + 1 - begin) % kTold == 0) meter.add(static_cast<double>(kTold) / n);
    }
  });
  return lists;
}

}  // namespace arap
