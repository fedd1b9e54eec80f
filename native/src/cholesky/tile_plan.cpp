// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/tile_plan.h"

#include <algorithm>
#include <utility>

#include "kernels/tile_kernels.h"

namespace arap {

namespace {

/// The columns above a branch that it has rows in, ascending.
std::vector<int> columns_above(const SupernodalStructure& structure, const Branch& branch) {
  std::vector<int> columns;
  for (int s = branch.begin; s < branch.end; ++s) {
    const Supernode& node = structure.supernodes[s];
    // Descendants have no rows above the branch that its roots do not have.
    if (node.parent >= 0 && node.parent < branch.end) continue;
    columns.insert(columns.end(), structure.rows_of(node), structure.rows_of(node) + node.n_rows);
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  return columns;
}

}  // namespace

TilePlan::TilePlan(SupernodalStructure the_structure, int the_n_threads)
    : structure(std::move(the_structure)),
      is_in_order(std::is_sorted(structure.order.begin(), structure.order.end())),
      n_threads(the_n_threads),
      partition(make_partition(structure, n_threads)) {
  // Which place each column has for the branch at hand.
  std::vector<int> place(n_columns());
  for (int c = 0; c < n_columns(); ++c) place[c] = c;
  n_places = n_columns();
  for (const Branch& branch : partition.branches) {
    copies.push_back({n_places, columns_above(structure, branch)});
    n_places += static_cast<int>(copies.back().columns.size());
  }
  // Two for each branch and for the top: threads that share a supernode never share padding of columns and of rows.
  first_padding = n_places;
  n_places += 2 * static_cast<int>(partition.branches.size() + 1);

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
  for (const int s : partition.top) write_rows(s, padding);
  for (size_t b = 0; b < partition.branches.size(); ++b) {
    padding += 2;
    int next = copies[b].first_place;
    for (const int c : copies[b].columns) place[c] = next++;
    for (int s = partition.branches[b].begin; s < partition.branches[b].end; ++s) write_rows(s, padding);
    for (const int c : copies[b].columns) place[c] = c;
  }
}

}  // namespace arap
