// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "cholesky/supernodes.h"

namespace arap {

/// Consecutive supernodes with all their descendants: no other supernode writes to their columns.
struct Subtree {
  int begin;
  int end;
  double cost;
};

/// The elimination tree cut into subtrees, which threads take one by one, and the root part above them.
struct SubtreePartition {
  std::vector<Subtree> subtrees;  ///< the most costly first
  std::vector<int> root_part;     ///< supernodes, ascending
};

/// What a solve needs of the pattern: where tiles lie, which thread does what, and where in the vector x each supernode
/// finds its rows.
///
/// x has places of 4 floats: the columns in the factor's ordering, then for each subtree copies of the columns of the
/// root part that it reaches, then padding. During elimination a subtree adds to its copies, and the root part collects
/// them; before back substitution the root part fills them. So subtrees are independent of each other, and sums do not
/// depend on the order in which threads finish.
struct TilePlan {
  struct Copies {
    int first_place;
    std::vector<int> columns;  ///< that are copied
  };

  TilePlan(SupernodalStructure the_structure, int n_threads);

  [[nodiscard]] int n_columns() const { return static_cast<int>(structure.ordering.size()); }

  SupernodalStructure structure;
  bool has_identity_ordering;  ///< structure.ordering[k] = k
  int n_threads;
  SubtreePartition partition;
  std::vector<Copies> copies;  ///< of each subtree
  int first_padding = 0;       ///< places from here on are padding
  int n_places = 0;
  std::vector<int> rows;             ///< TileSupernode::rows of all
  std::vector<size_t> rows_offsets;  ///< of each supernode, in `rows`
  std::vector<size_t> tile_offsets;  ///< of each supernode, and the end; counted in tiles
};

/// Number of tiles for n columns or rows.
[[nodiscard]] constexpr int tiles_for(int n) { return (n + 3) / 4; }

}  // namespace arap
