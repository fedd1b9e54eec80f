// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/SparseCholesky>

#include "linear_solver.h"

namespace arap {

/// Eigen's simplicial LDL^T with approximate minimum degree ordering.
class SimplicialLdlt final : public LinearSolver {
 public:
  void factorize(const SparseMatrix& A, const std::vector<char>& is_erased) override;
  void solve(Positions& b) const override;

 private:
  std::vector<int> kept_;  ///< the rows of A that are left
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> factor_;
};

}  // namespace arap
