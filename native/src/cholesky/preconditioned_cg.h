// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "arap/types.h"
#include "parallel/workers.h"

namespace arap {

/// The best accuracy that rounding in double allows.
inline constexpr double kDoubleAccuracy = 1e-15;

/// Replaces b (n, 3) by x = A^-1 b: preconditioned conjugate gradients, which converge even if the preconditioner is a
/// poor approximation. With a good one they are iterative refinement: two products and three solves.
///
/// @param apply     y = A x, (n, 3), without erased rows and columns: y is 0 there if x is
/// @param solve     preconditioner, a symmetric x = M^-1 residual with about A for M. Where that solves in a subspace
///                  only, it may take out of the residual what the subspace does not see: b becomes the x in there. b
///                  must be 0 in erased rows
/// @param accuracy  stops when the estimated relative error of x is below
void solve_with_cg(const std::function<void(const Positions& x, Positions& y)>& apply,
                   const std::function<void(Positions& residual, Positions& x)>& solve, Positions& b,
                   const Workers& workers, double accuracy = kDoubleAccuracy);

}  // namespace arap
