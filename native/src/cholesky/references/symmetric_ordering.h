// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/OrderingMethods>

#include "sparse/sparse.h"

namespace arap {

/// Approximate minimum degree for Eigen's general factorizations. Their default, COLAMD, does not know that the matrix
/// is symmetric and gives twice the fill; Eigen's AMDOrdering gives the inverse of what they take.
struct SymmetricOrdering {
  using PermutationType = Eigen::AMDOrdering<int>::PermutationType;

  void operator()(const SparseMatrix& A, PermutationType& permutation) const {
    PermutationType inverse;
    Eigen::AMDOrdering<int>()(A, inverse);
    permutation = inverse.inverse();
  }
};

}  // namespace arap
