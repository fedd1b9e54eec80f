// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/point_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace arap {

PointTree::PointTree(const Positions& points) : points_(points), order_(points.rows()) {
  std::iota(order_.begin(), order_.end(), 0);
  split(0, static_cast<int>(order_.size()));
}

void PointTree::split(int begin, int end) {
  if (end - begin <= kLeaf) return;
  Eigen::AlignedBox3d box;
  for (int k = begin; k < end; ++k) box.extend(points_.row(order_[k]).transpose());
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
    return points_(a, axis) < points_(b, axis) || (points_(a, axis) == points_(b, axis) && a < b);
  });
  const size_t node = nodes_.size();
  nodes_.push_back({middle, axis, points_(order_[middle], axis)});
  after_.push_back(0);
  split(begin, middle);
  after_[node] = static_cast<int>(nodes_.size());
  split(middle, end);
}

struct PointTree::Query {
  const Eigen::RowVector3d& place;
  size_t k;
  std::vector<Near>& found;
  double squared_slack;

  [[nodiscard]] bool may_be_nearer(double squared) const {
    return found.size() < k || squared_slack * squared <= found.back().squared;
  }
  void take(const Near& near) const {
    const auto is_nearer = [](const Near& a, const Near& b) {
      return a.squared < b.squared || (a.squared == b.squared && a.point < b.point);
    };
    if (found.size() == k && !is_nearer(near, found.back())) return;
    if (found.size() == k) found.pop_back();
    found.insert(std::upper_bound(found.begin(), found.end(), near, is_nearer), near);
  }
};

void PointTree::search(const Query& query, int begin, int end, int node, const Eigen::RowVector3d& beyond) const {
  if (end - begin <= kLeaf) {
    for (int i = begin; i < end; ++i) query.take({(points_.row(order_[i]) - query.place).squaredNorm(), order_[i]});
    return;
  }
  const Node& here = nodes_[node];
  const double above = query.place[here.axis] - here.plane;
  const auto visit = [&](bool is_lower, const Eigen::RowVector3d& outside) {
    if (is_lower)
      search(query, begin, here.end_of_lower, node + 1, outside);
    else
      search(query, here.end_of_lower, end, after_[node], outside);
  };
  visit(above < 0, beyond);
  Eigen::RowVector3d across = beyond;
  across[here.axis] = above;
  if (query.may_be_nearer(across.squaredNorm())) visit(above >= 0, across);
}

void PointTree::nearest(const Eigen::RowVector3d& place, int k, std::vector<Near>& found, double slack) const {
  found.clear();
  search({place, static_cast<size_t>(k), found, slack * slack}, 0, static_cast<int>(order_.size()), 0,
         Eigen::RowVector3d::Zero());
}

}  // namespace arap
