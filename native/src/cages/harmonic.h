// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "arap/types.h"
#include "cages/cage.h"
#include "cages/weight_blocks.h"
#include "parallel/meter.h"
#include "parallel/workers.h"

namespace arap {

/// Harmonic coordinates [JMD07] of points, (n, 3) in the cage's space: the weight of a vertex is the function without
/// sources inside that is its hat on the cage. Between the nodes of a grid (harmonic_grid.h) values are trilinear. In
/// cells that the cage passes through, they are averages of the nodes inside, of where the cage meets the cell's edges
/// and of the triangles near the point, weighted by one over the squared distance; so they go over into the hats.
/// @param spacing  of the grid
/// @param weights  has a row for each vertex; they are repaired
/// @return  indices of the points that are outside of the cage, ascending
[[nodiscard]] std::vector<int> harmonic_weights(const Cage& cage, double spacing, const Positions& points,
                                                const Workers& workers, const MeterPart& meter, WeightBlocks& weights);

/// Makes weights sum to 1 and give the point, by the smallest change relative to their sizes.
void repair_weights(const Cage& cage, const Eigen::RowVector3d& point, Eigen::VectorXd& weights);

}  // namespace arap
