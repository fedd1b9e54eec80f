// SPDX-License-Identifier: GPL-3.0-or-later
// arap::all: Eigen's index of all rows or columns, which 3.4 and 5 have in different namespaces.
#pragma once

#include <Eigen/Core>

namespace arap {
#if EIGEN_VERSION_AT_LEAST(5, 0, 0)
using Eigen::placeholders::all;
#else
using Eigen::all;
#endif
}  // namespace arap
