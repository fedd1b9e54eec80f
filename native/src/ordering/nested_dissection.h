// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "sparse/sparse.h"

namespace arap {

/// A fill-reducing order of the unknowns, order[new] = old.
///
/// Elimination couples all neighbours of the eliminated unknown. Nested dissection keeps that local: a small separator
/// that cuts the graph in two halves comes last, each half is ordered the same way, and nothing couples one half with
/// the other. For meshes the factor then has O(n log n) entries.
///
/// @param pattern  symmetric, stored whole
/// @param threads  to work on; the order does not depend on them
[[nodiscard]] std::vector<int> nested_dissection(const SparseMatrix& pattern, int threads);

}  // namespace arap
