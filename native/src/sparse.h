// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/SparseCore>

#include "arap/types.h"
#include "workers.h"

namespace arap {

/// Symmetric matrices are stored whole, so that a column is a row and can be gathered.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// result = A x for a symmetric A stored whole; (n, 3).
void multiply(const SparseMatrix& A, const Positions& x, Positions& result, const Workers& workers);

}  // namespace arap
