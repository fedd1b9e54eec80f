// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

namespace arap {

/// (n, 3) points or vectors, row-major like a C-ordered numpy array.
using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

/// Called from the calling thread with the fraction done, in [0, 1]; returns false to stop the work.
/// An exception thrown by it passes through and leaves the called object as it was. Empty: not called.
using Progress = std::function<bool(double fraction)>;

}  // namespace arap
