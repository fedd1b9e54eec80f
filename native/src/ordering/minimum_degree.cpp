// SPDX-License-Identifier: GPL-3.0-or-later
#include "ordering/minimum_degree.h"

#include <algorithm>

namespace arap {

std::vector<int> minimum_degree(std::vector<SmallRow> rows, int n) {
  std::vector<int> order;
  order.reserve(n);
  std::vector<int> left(n);
  std::vector<int> degrees(n);
  for (int v = 0; v < n; ++v) {
    left[v] = v;
    degrees[v] = static_cast<int>(rows[v].count());
  }
  while (!left.empty()) {
    const auto next = std::min_element(left.begin(), left.end(), [&](int a, int b) { return degrees[a] < degrees[b]; });
    const int v = *next;
    left.erase(next);
    order.push_back(v);
    const SmallRow clique = rows[v];
    for (const int u : left) {
      if (!clique[u]) continue;
      rows[u] |= clique;
      rows[u].reset(u);
      rows[u].reset(v);
      degrees[u] = static_cast<int>(rows[u].count());
    }
  }
  return order;
}

}  // namespace arap
