// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "cholesky/subtree_partition.h"
#include "cholesky/supernodes.h"

namespace arap {

/// Everything of a solve that depends on the pattern alone: where tiles lie, which thread does what, and where in the
/// vector x each supernode finds its rows.
///
/// x has places of 4 floats: the columns in the factor's order, then for each branch copies of the columns of the top
/// that it reaches. During elimination a branch adds to its copies, and the top collects them; for back substitution
/// the top fills them. So branches need nothing of each other, and sums do not depend on who came first. Last come
/// places for padding.
struct TilePlan {
  struct Copies {
    int first_place;
    std::vector<int> columns;  ///< that are copied
  };

  TilePlan(SupernodalStructure the_structure, int n_threads);

  [[nodiscard]] int n_columns() const { return static_cast<int>(structure.order.size()); }

  SupernodalStructure structure;
  bool is_in_order;  ///< the unknowns are numbered as the columns, structure.order[k] = k
  int n_threads;
  Partition partition;
  std::vector<Copies> copies;  ///< of each branch
  int first_padding = 0;       ///< the places from here on are padding
  int n_places = 0;
  std::vector<int> rows;             ///< TileSupernode::rows of all
  std::vector<size_t> rows_offsets;  ///< of each supernode, in `rows`
  std::vector<size_t> tile_offsets;  ///< of each supernode, and the end; in tiles
};

/// Columns and rows of a supernode in tiles.
[[nodiscard]] constexpr int tiles_for(int n) { return (n + 3) / 4; }

}  // namespace arap
