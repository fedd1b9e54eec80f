// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/cage.h"
#include "arap/types.h"
#include "cages/cage.h"
#include "cages/weight_blocks.h"
#include "kernels/isa.h"
#include "parallel/meter.h"

namespace arap {

/// Rows of weights that a kind of coordinates has: one a vertex, and for some one a triangle after them.
[[nodiscard]] int n_weight_rows(const Cage& cage, CageCoordinates coordinates);

/// Weights of points, (n, 3) in the cage's space. Not for kHarmonic: its weights are not of one point alone.
/// @return  indices of the points that have none, ascending: for kGreen those that are not inside
[[nodiscard]] std::vector<int> compute_weights(const Cage& cage, CageCoordinates coordinates, const Positions& points,
                                               int threads, const MeterPart& meter, WeightBlocks& weights,
                                               Isa isa = choose_isa());

/// The same of one point in double.
[[nodiscard]] CageWeights weights_of(const Cage& cage, CageCoordinates coordinates, const Eigen::RowVector3d& point);

}  // namespace arap
