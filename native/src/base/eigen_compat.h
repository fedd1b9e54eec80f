// SPDX-License-Identifier: GPL-3.0-or-later
// Eigen's index of all rows or columns, as arap::all: Eigen 5 has it in another namespace than 3.4.
#pragma once

#include <Eigen/Core>

namespace arap {
#if EIGEN_VERSION_AT_LEAST(5, 0, 0)
using Eigen::placeholders::all;
#else
using Eigen::all;
#endif
}  // namespace arap
