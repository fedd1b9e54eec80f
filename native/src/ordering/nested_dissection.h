// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "parallel/meter.h"
#include "sparse/sparse.h"

namespace arap {

/// A fill-reducing ordering of the unknowns, ordering[new] = old.
///
/// Elimination couples all neighbours of the eliminated unknown. Nested dissection [George 1973] keeps that local: a
/// small separator that cuts the graph into two halves comes last, and each half is ordered the same way, so nothing
/// couples the halves. For meshes the factor then has O(n log n) entries.
///
/// @param pattern  symmetric, stored whole
/// @param threads  to work on; the ordering does not depend on them
/// @param entry_bytes  of an entry of the factor. Throws NotEnoughMemory as soon as the separators show that the factor
/// does not fit.
[[nodiscard]] std::vector<int> nested_dissection(const SparseMatrix& pattern, int threads, const MeterPart& meter = {},
                                                 size_t entry_bytes = 0);

}  // namespace arap
