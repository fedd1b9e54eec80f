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

/// result[k] = values[order[k]]
template <class Value>
[[nodiscard]] std::vector<Value> permuted(const std::vector<Value>& values, const std::vector<int>& order) {
  std::vector<Value> result;
  result.reserve(order.size());
  for (const int i : order) result.push_back(values[i]);
  return result;
}

}  // namespace arap
