// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Kernels include this header: no inline functions here, see kernels/simd.h.

namespace arap {

/// The exact fit, for covariances that the kernels' fast fit does not solve: the unit quaternion (x, y, z, w) of the
/// rotation that maximizes <R, S>, S row-major. If S is 0 it is `former`.
void fit_quaternion(const double* S, const double* former, double* quaternion);

}  // namespace arap
