// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "constraints/linear_rows.h"
#include "parallel/workers.h"

namespace arap {

/// Many sparse rows H, far stiffer than A: min 1/2 <x, A x> - <b, x> + 1/2 sum_r w_r |h_r x - g_r|^2. An augmented
/// Lagrangian: a factor of A + H^T P H with penalties P, about a hundred times as stiff as A there, and conjugate
/// residuals on f = (W - P) (H x - g), the forces beyond those of the penalties, which stay finite as the weights grow.
/// The penalties make their system, H (A + H^T P H)^-1 H^T + (W - P)^-1, nearly diagonal, so a few steps, of one solve
/// each, suffice. Rows may be redundant or contradict each other.
class StiffRows {
 public:
  /// Solves with A + H^T diag(penalties) H, maybe in a subspace: then x is the one in there.
  using Solve = std::function<void(Positions& x)>;

  /// @param penalties  (n_rows,) > 0
  /// @param weights    (n_rows,) above the penalties
  StiffRows(RowMatrix rows, const Eigen::VectorXd& penalties, const Eigen::VectorXd& weights, Workers workers);

  [[nodiscard]] const RowMatrix& rows() const { return rows_; }

  /// Sets x for b and g, and the multipliers, (n_rows, 3), which it starts from: the rows' forces w_r (h_r x - g_r).
  /// b may be x.
  /// @param accuracy  what is left of the gaps, as a part of those that the penalties alone leave
  void solve(double accuracy, const Solve& solve_penalized, const Positions& b, const Positions& gaps,
             Positions& multipliers, Positions& x) const;

 private:
  RowMatrix rows_;
  Eigen::ArrayXd penalties_;
  Eigen::ArrayXd compliance_;        ///< 1 / (w - p)
  Eigen::ArrayXd beyond_penalties_;  ///< (w - p) / w
  Eigen::ArrayXd scaling_;           ///< about the inverse of the multipliers' system
  Workers workers_;
};

}  // namespace arap
