// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bound_constraints.h"
#include "local_global.h"

namespace arap {

/// Of the linear solves of a guess: what iterations in single precision tell, so that a rigid motion of all handles is
/// one of the mesh.
inline constexpr double kGuessAccuracy = 1e-7;

/// min |L p' - L p|^2 under the constraints, L the Laplacian of the energy's weights; [SA07] Sec. 3. Rigid regions keep
/// their rotations.
void guess_naive_laplacian(const BoundModel& model, BoundConstraints& constraints, const Positions& vertex_targets,
                           const Positions& patch_targets, Pose& pose);

/// Turns all cells and regions by the harmonic interpolation of the handles' turns: K w = 0 for the rotation vectors w.
/// One global step makes positions of them.
/// @param turns  (n_entries + n_patches, 3) rotation vectors
void spread_turns(const BoundModel& model, const BoundConstraints& constraints, const Positions& turns, Pose& pose);

}  // namespace arap
