// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "arap/types.h"

namespace arap {

/// Normal of a face, with twice its area for a length; of one that is not plane, that of its shadow along the normal.
/// @param positions  (n, 3)
[[nodiscard]] inline Eigen::RowVector3d twice_vector_area(const Positions& positions, std::span<const int> face) {
  using Row = Eigen::RowVector3d;
  const Row first = positions.row(face[0]);
  Row doubled = Row::Zero();
  for (size_t k = 1; k + 1 < face.size(); ++k)
    doubled += Row(positions.row(face[k]) - first).cross(Row(positions.row(face[k + 1]) - first));
  return doubled;
}

}  // namespace arap
