// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/types.h"

namespace arap {

/// The rotation R (det +1) that maximizes <R, S> = tr(R^T S), the polar rotation of S (orthogonal Procrustes problem,
/// Wahba's problem). With S = U Sigma V^T it is U diag(1, 1, d) V^T, d = +-1. [SA07] Eq. (6), whose covariance is
/// transposed. `previous`, a rotation, is the starting point: a good one makes the fit fast. The result depends on it
/// only if the maximum is not unique; if S is 0, the result is `previous`.
[[nodiscard]] Matrix3 nearest_rotation(const Matrix3& S, const Matrix3& previous);

/// The rotation by the least angle that turns `from` to the direction of `to`; of opposite ones, about any axis across.
/// Neither is 0.
[[nodiscard]] Matrix3 rotation_between(const Vector3& from, const Vector3& to);

/// The rotation that maximizes <R, S> under the constraint R from = to; `from` and `to` are unit vectors.
[[nodiscard]] Matrix3 nearest_rotation_with_axis(const Matrix3& S, const Vector3& from, const Vector3& to,
                                                 const Matrix3& previous);

}  // namespace arap
