// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "parallel/meter.h"
#include "wrap/surface_at_rest.h"

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
  std::vector<int> counts;     ///< of each point
  std::vector<int> nearest;    ///< of each point: the nearest node of the first level
  std::vector<double> around;  ///< of each point: how much it hangs on walls on all sides, 0 to 1
};

/// The anchors of each point, and their weights, of sum 1. The nodes are about as far apart as the point is from the
/// surface; a point between two levels has anchors of both.
///
/// A point deep inside, with walls on all sides, hangs on all of them: on the nodes within 2.5 times its distance, 256
/// of a level at the most. On the nearest wall alone it would leave its neighbours that are nearer to another one. In
/// between a point has a share of either.
/// @param points     (n, 3) in the space of the surface
/// @param n_anchors  of each level
/// @return  lists that follow each other
[[nodiscard]] std::vector<AnchorLists> find_anchors(const SurfaceAtRest& surface, const Positions& points,
                                                    int n_anchors, int threads, const MeterPart& meter);

}  // namespace arap
