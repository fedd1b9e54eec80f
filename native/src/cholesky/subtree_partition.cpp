// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/subtree_partition.h"

#include <algorithm>
#include <iterator>

namespace arap {

namespace {

constexpr double kSubtreesPerThread = 3;

/// Cost and first supernode of the subtree of each supernode.
struct SubtreeCosts {
  std::vector<double> cost;
  std::vector<int> begin;

  explicit SubtreeCosts(const std::vector<Supernode>& supernodes)
      : cost(supernodes.size(), 0), begin(supernodes.size()) {
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

SubtreePartition make_partition(const SupernodalStructure& structure, int n_threads) {
  const auto& supernodes = structure.supernodes;
  const auto n = static_cast<int>(supernodes.size());
  SubtreePartition partition;
  if (n == 0) return partition;
  const SubtreeCosts costs(supernodes);
  double total = 0;
  for (int s = 0; s < n; ++s)
    if (supernodes[s].parent < 0) total += costs.cost[s];
  if (n_threads <= 1) {
    partition.subtrees.push_back({0, n, total});
    return partition;
  }
  const double most = total / (kSubtreesPerThread * n_threads);
  const auto is_root_part = [&](int s) { return costs.cost[s] > most; };
  for (int s = 0; s < n; ++s) {
    if (is_root_part(s)) {
      partition.root_part.push_back(s);
      continue;
    }
    const int parent = supernodes[s].parent;
    if (parent >= 0 && !is_root_part(parent)) continue;
    // A whole subtree. Join small neighbours.
    const Subtree subtree{costs.begin[s], s + 1, costs.cost[s]};
    Subtree* last = partition.subtrees.empty() ? nullptr : &partition.subtrees.back();
    if (last != nullptr && last->end == subtree.begin && last->cost + subtree.cost <= most) {
      last->end = subtree.end;
      last->cost += subtree.cost;
    } else {
      partition.subtrees.push_back(subtree);
    }
  }
  std::stable_sort(partition.subtrees.begin(), partition.subtrees.end(),
                   [](const Subtree& a, const Subtree& b) { return a.cost > b.cost; });
  return partition;
}

}  // namespace arap
