// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace arap {

/// Disjoint sets of 0 .. n-1; the lowest member represents its set.
class UnionFind {
 public:
  explicit UnionFind(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  /// Another set, of a new member.
  int add() {
    parent_.push_back(size());
    return size() - 1;
  }
  [[nodiscard]] int size() const { return static_cast<int>(parent_.size()); }

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

}  // namespace arap
