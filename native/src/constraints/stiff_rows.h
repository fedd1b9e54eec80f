// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "cholesky/linear_solver.h"
#include "constraints/linear_rows.h"
#include "parallel/workers.h"

namespace arap {

/// Factor of A + H^T diag(w) H with rows H so stiff that numbers of their size would drown those of A: a factor of
/// A + H^T diag(p) H with penalties p <= w, and conjugate gradients on the forces of the rows (the multipliers of an
/// augmented Lagrangian). The penalties make their system nearly diagonal, so a few steps, of one solve each, suffice.
class StiffRows final : public Factorization {
 public:
  /// @param factor     of A + H^T diag(penalties) H, which may have erased rows
  /// @param rows       H
  /// @param weights    (n_rows,) w, not below the penalties
  StiffRows(std::unique_ptr<Factorization> factor, const RowMatrix& rows, Eigen::VectorXd weights,
            Eigen::VectorXd penalties, Workers workers);

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override;
  [[nodiscard]] size_t bytes() const override { return factor_->bytes(); }

 private:
  std::unique_ptr<Factorization> factor_;
  const RowMatrix& rows_;
  Eigen::ArrayXd compliance_;  ///< 1 / (w - p)
  Eigen::ArrayXd scaling_;     ///< about the inverse of the system's diagonal
  Workers workers_;
};

}  // namespace arap
