// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/anchor_search.h"

#include <algorithm>
#include <cmath>

#include "base/available_memory.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// Distance of a point from the surface over the distance of its anchors.
constexpr double kDistancePerSpacing = 2;
/// The same where there are walls all around: their anchors are more, so they may be coarser.
constexpr double kDistancePerSpacingAround = 1.5;
/// Their anchors reach so many times as far as the nearest wall: the opposite one of a limb counts where a place is not
/// farther from the middle than 3/7 of the radius.
constexpr double kReachAround = 2.5;
constexpr int kMostAround = 256;  // of a level
/// The outermost anchors weigh next to nothing, so the choice between them, which may be one of rounding, is not seen.
constexpr double kBeyondFarthest = 1.001;

/// Finds the anchors of one point after another. A thread has its own.
class Search {
 public:
  Search(const SurfaceAtRest& surface, int n_anchors)
      : surface_(surface), levels_(surface.levels()), n_anchors_(static_cast<size_t>(n_anchors)) {
    last_seen_.reserve(levels_.size());
    for (int l = 0; l < levels_.size(); ++l) last_seen_.emplace_back(levels_.level(l).n_nodes(), -1);
  }

  void add_anchors(const Row& place, AnchorLists& lists) {
    make_room(lists);
    const size_t before = lists.anchors.size();
    constexpr double kSlack = 1.1;
    constexpr double kNear = 8;  // mean edges: from there on, nearly the nearest will do, as anchors are coarse
    surface_.tree().nearest(place, 1, found_, kSlack);
    if (found_[0].squared < std::pow(kNear * levels_.spacing(), 2)) surface_.tree().nearest(place, 1, found_);
    const int node = found_[0].point;
    const double spacings = std::sqrt(found_[0].squared) / levels_.spacing();
    lists.nearest.push_back(node);
    double around = 0;
    if (spacings > kShallow && surface_.triangles().is_behind(node, place.transpose()))
      around = add_around(place, node, spacings, lists);
    lists.around.push_back(around);
    if (around < 1)
      for_levels(node, spacings / kDistancePerSpacing, [&](int level, int start, double share) {
        choose(place, level, start, n_anchors_, 0);
        add_chosen(level, (1 - around) * share, lists);
      });
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

  /// In mean edges of the surface: what is nearer hangs on the nearest wall alone.
  static constexpr double kShallow = .75;
  static constexpr double kDeep = 1.25;

  /// Calls visit(level, node, share) for the two levels whose nodes are about so far apart, in mean edges, with the
  /// nodes that stand for a node of the first level.
  template <class Visit>
  void for_levels(int node, double spacings, const Visit& visit) const {
    const double depth = std::clamp(std::log2(std::max(spacings, 1.)), 0., levels_.size() - 1.);
    const double fine = std::floor(depth);
    const double coarse_share = smooth(depth - fine);
    const auto level = static_cast<int>(fine);
    for (int l = 0; l < level; ++l) node = levels_.level(l).coarser[node];
    visit(level, node, 1 - coarse_share);
    if (coarse_share > 0) visit(level + 1, levels_.level(level).coarser[node], coarse_share);
  }

  /// For the most that a point may hang on.
  void make_room(AnchorLists& lists) const {
    const size_t size = lists.anchors.size() + 2 * (kMostAround + n_anchors_);
    if (size <= lists.anchors.capacity()) return;
    const size_t room = std::max(size, 2 * lists.anchors.capacity());
    require_memory(static_cast<double>(room * sizeof(PointAnchor)), "so many points");
    lists.anchors.reserve(room);
  }

  static double smooth(double t) { return t * t * (3 - 2 * t); }

  /// Adds the walls all around, if there are: their share of the point, 0 to 1.
  double add_around(const Row& place, int node, double spacings, AnchorLists& lists) {
    const size_t first = lists.anchors.size();
    Row ways = Row::Zero();  // the mean of the unit vectors to the anchors: long if all are on one side
    for_levels(node, spacings / kDistancePerSpacingAround, [&](int level, int start, double share) {
      const size_t before = lists.anchors.size();
      choose(place, level, start, kMostAround, kReachAround * spacings * levels_.spacing());
      add_chosen(level, share, lists);
      for (size_t k = before; k < lists.anchors.size(); ++k)
        ways += lists.anchors[k].weight * (levels_.level(level).places.row(lists.anchors[k].node) - place).normalized();
    });
    constexpr double kOneSide = .75;  // of a plane it is .83
    constexpr double kAllSides = .5;  // of a right angle .58
    const double around = smooth(std::clamp((kOneSide - ways.norm()) / (kOneSide - kAllSides), 0., 1.)) *
                          smooth(std::clamp((spacings - kShallow) / (kDeep - kShallow), 0., 1.));
    if (!(around > 0)) lists.anchors.resize(first);
    for (size_t k = first; k < lists.anchors.size(); ++k) lists.anchors[k].weight *= around;
    return around;
  }

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

  /// The nearest nodes that are connected with the one nearest to the place through such, sorted: `most` and one more,
  /// if there are; with a reach > 0 those within it, and as many as usual at least.
  /// @param start  a node near to the place
  void choose(const Row& place, int l, int start, size_t most, double reach) {
    const SurfaceLevel& level = levels_.level(l);
    std::vector<int>& last_seen = last_seen_[l];
    ++search_;
    chosen_.clear();
    heap_.clear();
    const auto push = [&](int node) {
      if (last_seen[node] == search_) return;
      last_seen[node] = search_;
      heap_.push_back({squared_distance(level, node, place), node});
      std::push_heap(heap_.begin(), heap_.end());
    };
    const auto is_wanted = [&](const Candidate& next) {
      return chosen_.size() <= (reach > 0 ? n_anchors_ : most) ||
             (chosen_.size() <= most && next.squared < reach * reach);
    };
    push(descend(level, start, place));
    while (!heap_.empty() && is_wanted(heap_.front())) {
      std::pop_heap(heap_.begin(), heap_.end());
      chosen_.push_back(heap_.back());
      heap_.pop_back();
      for (const int other : level.around(chosen_.back().node)) push(other);
    }
    std::sort(chosen_.begin(), chosen_.end(), [](const Candidate& a, const Candidate& b) { return b < a; });
    farthest_ = kBeyondFarthest * std::sqrt(chosen_.back().squared);
    if (chosen_.size() > most)
      chosen_.pop_back();
    else
      farthest_ = std::max(farthest_, reach);
  }

  /// Adds what is chosen.
  /// @param share  the sum of the weights
  void add_chosen(int level, double share, AnchorLists& lists) const {
    // So near to a vertex it has all the weight.
    constexpr double kNearest = 1e-9;
    const double R = farthest_;
    double sum = 0;
    const size_t first = lists.anchors.size();
    for (const Candidate& anchor : chosen_) {
      const double d = std::max(std::sqrt(anchor.squared), kNearest * R);
      const double root = R > 0 ? (R - d) / (R * d) * R : 1;
      lists.anchors.push_back({level, anchor.node, root * root});
      sum += root * root;
    }
    for (size_t k = first; k < lists.anchors.size(); ++k) lists.anchors[k].weight *= share / sum;
  }

  const SurfaceAtRest& surface_;
  const SurfaceLevels& levels_;
  size_t n_anchors_;
  int search_ = -1;
  std::vector<std::vector<int>> last_seen_;  ///< of each level and node: the last search that has looked at it
  std::vector<PointTree::Near> found_;
  std::vector<Candidate> heap_;
  std::vector<Candidate> chosen_;
  double farthest_ = 0;  ///< where weights vanish
};

}  // namespace

std::vector<AnchorLists> find_anchors(const SurfaceAtRest& surface, const Positions& points, int n_anchors, int threads,
                                      const MeterPart& meter) {
  const auto n = static_cast<int>(points.rows());
  const Shares shares(threads, n);
  std::vector<AnchorLists> lists(shares.count());
  shares.for_each([&](int share, int begin, int end) {
    Search search(surface, n_anchors);
    for (int p = begin; p < end; ++p) {
      search.add_anchors(points.row(p), lists[share]);
      constexpr int kTold = 512;
      if ((p + 1 - begin) % kTold == 0) meter.add(static_cast<double>(kTold) / n);
    }
  });
  return lists;
}

}  // namespace arap
