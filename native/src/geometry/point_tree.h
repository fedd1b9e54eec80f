// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"

namespace arap {

/// Points in a k-d tree, for the nearest ones at any distance.
class PointTree {
 public:
  struct Near {
    double squared;  ///< distance
    int point;
  };

  /// @param points  (n, 3), n >= 1, kept by reference
  explicit PointTree(const Positions& points);

  /// The k nearest points, or all if there are fewer, the nearest first; of equally near ones the lowest.
  /// @param slack  >= 1: others may be nearer by this factor, which makes searches from far away faster
  void nearest(const Eigen::RowVector3d& place, int k, std::vector<Near>& found, double slack = 1) const;

 private:
  struct Node {
    int end_of_lower;  ///< of the points: those below the plane come first
    int axis;
    double plane;
  };

  static constexpr int kLeaf = 8;

  void split(int begin, int end);
  struct Query;
  /// @param beyond  along each axis: how far the place is from the box of the node
  void search(const Query& query, int begin, int end, int node, const Eigen::RowVector3d& beyond) const;

  const Positions& points_;
  std::vector<int> order_;   ///< the points, those of a node one after the other
  std::vector<Node> nodes_;  ///< inner ones, each before its children, the lower ones first
  std::vector<int> after_;   ///< of each inner node: the first one behind those of its lower half
};

}  // namespace arap
