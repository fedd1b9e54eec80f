// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/types.h"

namespace arap {

/// The rotation R (det +1) that maximizes <R, S> = tr(R^T S): with S = U Sigma V^T it is U diag(1, 1, d) V^T, d = +-1.
/// [SA07] Eq. (6), there with the covariance transposed. Where S is 0 every rotation is as good: `previous` is kept. A
/// good `previous`, which must be a rotation, makes it fast; the result does not depend on it where the maximum is
/// unique.
[[nodiscard]] Matrix3 nearest_rotation(const Matrix3& S, const Matrix3& previous);

/// The rotation that maximizes <R, S> among those that turn the unit vector `from` into the unit vector `to`.
[[nodiscard]] Matrix3 nearest_rotation_with_axis(const Matrix3& S, const Vector3& from, const Vector3& to,
                                                 const Matrix3& previous);

}  // namespace arap
