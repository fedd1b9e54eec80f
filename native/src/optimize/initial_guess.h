// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "constraints/prepared_constraints.h"
#include "optimize/local_global.h"

namespace arap {

/// Of the global step that makes positions of turns, as a part of itself. Where all turn alike, what iterations in
/// single precision tell, so that a rigid motion of all handles is one of the mesh. Where turns differ, the first fit
/// changes them by far more than that.
/// @param turn_range  as spread_rotations() returns it
[[nodiscard]] double guess_accuracy(double turn_range);

/// min |L p' - L p|^2 under the constraints, L the Laplacian of the energy's weights; [SA07] Sec. 3. Rigid regions keep
/// their rotations.
void guess_naive_laplacian(const PreparedModel& model, PreparedConstraints& constraints,
                           const Positions& vertex_targets, const Positions& patch_targets, Pose& pose);

/// Turns all cells and regions by the harmonic interpolation of the handles' turns: K w = 0 for the rotation vectors w.
/// One global step makes positions of them. Returns how far the turn of a free unknown is at most from the mean of
/// its part, in radians.
/// @param turns  (n_entries + n_patches, 3) rotation vectors
double spread_rotations(const PreparedModel& model, const PreparedConstraints& constraints, const Positions& turns,
                        Pose& pose);

}  // namespace arap
