// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace arap {

/// inverse[order[k]] = k
[[nodiscard]] inline std::vector<int> inverse_permutation(const std::vector<int>& order) {
  std::vector<int> inverse(order.size());
  for (size_t k = 0; k < order.size(); ++k) inverse[order[k]] = static_cast<int>(k);
  return inverse;
}

}  // namespace arap
