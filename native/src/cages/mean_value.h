// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "cages/cage.h"

namespace arap {

/// Mean value coordinates [JSW05] of a point, (n_vertices,), of sum 1. The weight of a vertex, before it is scaled, is
/// the integral of its hat over what the point sees of the cage,
///
///     w_i = int hat_i(y) (y - x).N / |y - x|^4 dA.
///
/// With T_e = theta_e / s_e of an edge, the angle that it is seen at over the distance to its line, a triangle has
///
///     w_i = per_height_i / 2 (h_i S / d + d sum_e <m_i, m_e> T_e),    S = sum_e h_e T_e.
///
/// [JSW05] has another closed form, in which a weight loses all digits near the plane of a triangle. Here S / d alone
/// does, and it has a form without cancellation for a foot outside of the triangle. A point on a face, to 1e-12, has
/// that face's linear interpolation.
[[nodiscard]] Eigen::VectorXd mean_value_coordinates(const Cage& cage, const Eigen::RowVector3d& point);

}  // namespace arap
