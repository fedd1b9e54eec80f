// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "arap/error.h"

namespace arap {

/// Makes offsets of counts: counts[k + 1] is the number of entries of k, and becomes where they end. Throws
/// InvalidInput if there are more entries than indices.
inline void make_offsets(std::vector<int>& counts) {
  std::int64_t end = 0;
  for (int& count : counts) {
    end += count;
    count = static_cast<int>(end);
  }
  if (end > std::numeric_limits<int>::max())
    throw InvalidInput(
        "the mesh is too large: its lists of neighbours have more than 2^31 entries; pose a coarser one");
}

}  // namespace arap
