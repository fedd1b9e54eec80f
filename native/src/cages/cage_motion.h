// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "arap/types.h"
#include "cages/cage.h"

namespace arap {

/// x -> linear x + shift, of column vectors.
struct AffineMap {
  Matrix3 linear = Matrix3::Identity();
  Vector3 shift = Vector3::Zero();

  /// Row by row.
  [[nodiscard]] Positions apply(const Positions& points) const {
    return (points * linear.transpose()).rowwise() + shift.transpose();
  }
};

/// The affine map from the cage at rest, in its space, that comes closest to `moved`, (n_vertices, 3). Vertices in no
/// triangle do not count.
[[nodiscard]] AffineMap best_affine_map(const Cage& cage, const Positions& moved);

/// The same map as a matrix, (4, n_vertices): times `moved` it is the shift and then the transposed linear part.
[[nodiscard]] Eigen::Matrix4Xd affine_fit(const Cage& cage);

/// The same of a turn, a scale and a shift.
[[nodiscard]] AffineMap best_similarity(const Cage& cage, const Positions& moved);

/// The same of any points, (n, 3). Where they tell no scale, as one alone, it is 1.
[[nodiscard]] AffineMap best_similarity(const Positions& rest, const Positions& moved);

}  // namespace arap
