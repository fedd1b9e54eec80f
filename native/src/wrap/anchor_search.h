// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "geometry/point_tree.h"
#include "parallel/meter.h"
#include "wrap/surface_levels.h"

namespace arap {

/// A node that a point hangs on.
struct PointAnchor {
  int level;
  int node;
  double weight;
};

/// Of points one after the other.
struct AnchorLists {
  std::vector<PointAnchor> anchors;
  std::vector<int> counts;   ///< of each point
  std::vector<int> nearest;  ///< of each point: the nearest node of the first level
};

/// The anchors of each point, and their weights, of sum 1. The nodes are about as far apart as the point is from the
/// surface; a point between two levels has anchors of both.
/// @param tree       of the nodes of the first level
/// @param points     (n, 3) in the space of the levels
/// @param n_anchors  of each level
/// @return  lists that follow each other
[[nodiscard]] std::vector<AnchorLists> find_anchors(const SurfaceLevels& levels, const PointTree& tree,
                                                    const Positions& points, int n_anchors, int threads,
                                                    const MeterPart& meter);

}  // namespace arap
