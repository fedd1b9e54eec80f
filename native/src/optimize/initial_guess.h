// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "constraints/prepared_constraints.h"
#include "optimize/local_global.h"

namespace arap {

/// Relative accuracy of the global step that turns the spread rotations into positions. If all rotate alike, as exact
/// as iterations in single precision, so that a rigid motion of all handles is one of the mesh. If rotations differ,
/// the first fit changes them by far more than that.
/// @param range  as spread_rotations() returns it
[[nodiscard]] double guess_accuracy(double range);

/// min |L p' - L p|^2 under the constraints, L the Laplacian of the energy's weights; [SA07] Sec. 3. Rigid regions keep
/// their rotations.
/// @param targets         (n_targets, 3)
/// @param vertex_targets  (n, 3) the same of constrained vertices
void guess_naive_laplacian(const PreparedModel& model, PreparedConstraints& constraints, const Positions& targets,
                           const Positions& vertex_targets, Pose& pose);

/// Rotates all cells and regions by the harmonic interpolation of the handles' rotations: K w = 0 for the rotation
/// vectors w. One global step turns them into positions. Returns the largest difference of the rotation vector of a
/// free unknown from the mean of its part, in radians.
/// @param rotations  (n_targets, 3) rotation vectors
double spread_rotations(const PreparedModel& model, const PreparedConstraints& constraints, const Positions& rotations,
                        Pose& pose);

}  // namespace arap
