// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "sparse/sparse.h"

namespace arap {

/// Connected components of a symmetric matrix, coupled by entries other than 0: the lowest unknown of each unknown's
/// component.
[[nodiscard]] std::vector<int> connected_components(const SparseMatrix& A);

}  // namespace arap
