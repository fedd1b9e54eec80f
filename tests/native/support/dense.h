// SPDX-License-Identifier: GPL-3.0-or-later
// Dense systems, solved by Eigen. A source that instantiates one of its decompositions takes seconds to compile: so the
// tests have them here, behind functions.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace arap_test {

/// From b to the x with A x = b, by LU with full pivoting.
std::function<Eigen::MatrixXd(const Eigen::MatrixXd& b)> solver_of(const Eigen::MatrixXd& A);

/// The x that misses A x = b least; of those, the shortest.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

}  // namespace arap_test
