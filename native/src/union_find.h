// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "sparse.h"

namespace arap {

/// Disjoint sets of 0 .. n-1; the lowest member represents its set.
class UnionFind {
 public:
  explicit UnionFind(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  [[nodiscard]] int find(int i) {
    while (parent_[index(i)] != i) {
      parent_[index(i)] = parent_[index(parent_[index(i)])];
      i = parent_[index(i)];
    }
    return i;
  }

  void join(int i, int j) {
    i = find(i);
    j = find(j);
    parent_[index(std::max(i, j))] = std::min(i, j);
  }

 private:
  static size_t index(int i) { return i; }
  std::vector<int> parent_;
};

/// Of each unknown of a symmetric matrix the lowest one that it hangs together with by entries other than 0.
[[nodiscard]] inline std::vector<int> connected_components(const SparseMatrix& A) {
  const auto n = static_cast<int>(A.cols());
  UnionFind sets(n);
  for (int column = 0; column < n; ++column)
    for (SparseMatrix::InnerIterator it(A, column); it && it.row() < column; ++it)
      if (it.value() != 0) sets.join(column, static_cast<int>(it.row()));
  std::vector<int> components(n);
  for (int i = 0; i < n; ++i) components[i] = sets.find(i);
  return components;
}

}  // namespace arap
