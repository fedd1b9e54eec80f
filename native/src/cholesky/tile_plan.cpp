// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/tile_plan.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "kernels/tile_kernels.h"

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

/// About three subtrees a thread, so that a thread that loses its core does not stop the others. For one thread: one
/// subtree and no root part.
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

/// The columns of the root part that a subtree has rows in, ascending.
std::vector<int> columns_above(const SupernodalStructure& structure, const Subtree& subtree) {
  std::vector<int> columns;
  for (int s = subtree.begin; s < subtree.end; ++s) {
    const Supernode& node = structure.supernodes[s];
    // The rows above a subtree are those of its roots.
    if (node.parent >= 0 && node.parent < subtree.end) continue;
    columns.insert(columns.end(), structure.rows_of(node), structure.rows_of(node) + node.n_rows);
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  return columns;
}

}  // namespace

TilePlan::TilePlan(SupernodalStructure the_structure, int the_n_threads)
    : structure(std::move(the_structure)),
      has_identity_ordering(std::is_sorted(structure.ordering.begin(), structure.ordering.end())),
      n_threads(the_n_threads),
      partition(make_partition(structure, n_threads)) {
  // Place of each column for the subtree at hand.
  std::vector<int> place(n_columns());
  for (int c = 0; c < n_columns(); ++c) place[c] = c;
  n_places = n_columns();
  for (const Subtree& subtree : partition.subtrees) {
    copies.push_back({n_places, columns_above(structure, subtree)});
    n_places += static_cast<int>(copies.back().columns.size());
  }
  // Two for each subtree and for the root part: padding of columns and padding of rows must not share a place.
  first_padding = n_places;
  n_places += 2 * static_cast<int>(partition.subtrees.size() + 1);

  size_t n_rows = 0;
  size_t n_tiles = 0;
  for (const Supernode& node : structure.supernodes) {
    rows_offsets.push_back(n_rows);
    tile_offsets.push_back(n_tiles);
    const int columns = tiles_for(node.n_columns);
    const int strips = columns + tiles_for(node.n_rows);
    n_rows += size_t{kTile} * static_cast<size_t>(strips);
    n_tiles += tile_count(columns, strips);
  }
  tile_offsets.push_back(n_tiles);
  rows.resize(n_rows);

  const auto write_rows = [&](int s, int padding) {
    const Supernode& node = structure.supernodes[s];
    int* out = rows.data() + rows_offsets[s];
    for (int c = 0; c < kTile * tiles_for(node.n_columns); ++c)
      *out++ = c < node.n_columns ? node.first_column + c : padding;
    for (int r = 0; r < kTile * tiles_for(node.n_rows); ++r)
      *out++ = r < node.n_rows ? place[structure.rows_of(node)[r]] : padding + 1;
  };
  int padding = first_padding;
  for (const int s : partition.root_part) write_rows(s, padding);
  for (size_t b = 0; b < partition.subtrees.size(); ++b) {
    padding += 2;
    int next = copies[b].first_place;
    for (const int c : copies[b].columns) place[c] = next++;
    for (int s = partition.subtrees[b].begin; s < partition.subtrees[b].end; ++s) write_rows(s, padding);
    for (const int c : copies[b].columns) place[c] = c;
  }
}

}  // namespace arap
