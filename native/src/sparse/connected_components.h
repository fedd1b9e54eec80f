// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "sparse/sparse.h"

namespace arap {

/// Of each unknown of a symmetric matrix the lowest one that it hangs together with by entries other than 0.
[[nodiscard]] std::vector<int> connected_components(const SparseMatrix& A);

}  // namespace arap
