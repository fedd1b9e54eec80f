// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Kernels include this where the flags are of one instruction set: no header with inline functions may come in here.

namespace arap {

/// The exact fit for what the kernels leave open: the rotation that maximizes <R, S>, S row by row, as a quaternion;
/// `former` is kept where S is 0.
void fit_quaternion(const double* S, const double* former, double* quaternion);

}  // namespace arap
