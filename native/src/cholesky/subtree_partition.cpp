// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/subtree_partition.h"

#include <algorithm>
#include <iterator>

namespace arap {

namespace {

constexpr double kBranchesPerThread = 3;

/// For each supernode what its subtree costs and where that begins.
struct Subtrees {
  std::vector<double> cost;
  std::vector<int> begin;

  explicit Subtrees(const std::vector<Supernode>& supernodes) : cost(supernodes.size(), 0), begin(supernodes.size()) {
    for (int s = 0; s < std::ssize(supernodes); ++s) begin[s] = s;
    for (int s = 0; s < std::ssize(supernodes); ++s) {
      cost[s] += solve_cost(supernodes[s].n_columns, supernodes[s].n_rows);
      const int parent = supernodes[s].parent;
      if (parent < 0) continue;
      cost[parent] += cost[s];
      begin[parent] = std::min(begin[parent], begin[s]);
    }
  }
};

}  // namespace

Partition make_partition(const SupernodalStructure& structure, int n_threads) {
  const auto& supernodes = structure.supernodes;
  const auto n = static_cast<int>(supernodes.size());
  Partition partition;
  if (n == 0) return partition;
  const Subtrees subtrees(supernodes);
  double total = 0;
  for (int s = 0; s < n; ++s)
    if (supernodes[s].parent < 0) total += subtrees.cost[s];
  if (n_threads <= 1) {
    partition.branches.push_back({0, n, total});
    return partition;
  }
  const double most = total / (kBranchesPerThread * n_threads);
  const auto is_top = [&](int s) { return subtrees.cost[s] > most; };
  for (int s = 0; s < n; ++s) {
    if (is_top(s)) {
      partition.top.push_back(s);
      continue;
    }
    const int parent = supernodes[s].parent;
    if (parent >= 0 && !is_top(parent)) continue;
    // A whole subtree. Small neighbours go together.
    const Branch branch{subtrees.begin[s], s + 1, subtrees.cost[s]};
    Branch* last = partition.branches.empty() ? nullptr : &partition.branches.back();
    if (last != nullptr && last->end == branch.begin && last->cost + branch.cost <= most) {
      last->end = branch.end;
      last->cost += branch.cost;
    } else {
      partition.branches.push_back(branch);
    }
  }
  std::stable_sort(partition.branches.begin(), partition.branches.end(),
                   [](const Branch& a, const Branch& b) { return a.cost > b.cost; });
  return partition;
}

}  // namespace arap
