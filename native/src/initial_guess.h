// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "bound_constraints.h"
#include "local_global.h"

namespace arap {

/// min |L p' - L p|^2 under the constraints, L the Laplacian of the energy's weights; [SA07] Sec. 3. Rigid regions keep
/// their rotations.
void guess_naive_laplacian(const BoundModel& model, BoundConstraints& constraints, const Positions& vertex_targets,
                           const Positions& patch_targets, Pose& pose);

/// Sets the rotations of all cells and regions to the harmonic interpolation of the handles' rotations (each matrix
/// entry harmonic, then the nearest rotation). One global step makes positions of them.
/// @param rotations  of each entry and then each patch
void spread_handle_rotations(const BoundModel& model, const BoundConstraints& constraints,
                             std::span<const Matrix3> rotations, Pose& pose);

/// Rotations from targets alone: each connected group of constrained vertices takes the rotation that fits its targets
/// best; a group that determines none (a point, a line) takes the mean of the other groups', or where there is none
/// the rotation that fits all targets.
/// @param targets  (n_entries + n_patches, 3) in model space
[[nodiscard]] std::vector<Matrix3> estimate_rotations(const BoundModel& model, const BoundConstraints& constraints,
                                                      const Positions& targets);

}  // namespace arap
