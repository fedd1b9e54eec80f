// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "cholesky/linear_solver.h"

namespace arap {

/// What rounding leaves to solve_with_cg().
inline constexpr double kDoubleAccuracy = 1e-15;

/// Replaces b (n, 3) by x = A^-1 b, by default to about the accuracy of double, with a factorization that may be less
/// exact: conjugate gradients with the factor as preconditioner, so that it converges whatever the quality of that is.
/// With a good one it is iterative refinement: two products and three solves.
///
/// @param apply     y = A x, (n, 3), without erased rows and columns: there y is 0 where x is
/// @param factor    of A; b is 0 in erased rows
/// @param accuracy  of x, as a part of it: it ends with the step that leaves no larger error, as far as this step
///                  and the one before can tell
void solve_with_cg(const std::function<void(const Positions& x, Positions& y)>& apply, const Factorization& factor,
                   Positions& b, const Workers& workers, double accuracy = kDoubleAccuracy);

}  // namespace arap
