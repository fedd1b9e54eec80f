// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "sparse/sparse.h"

namespace arap {

/// Consecutive columns of L with the same rows: a dense triangle of n_columns above a rectangle of n_rows.
struct Supernode {
  int first_column;
  int n_columns;
  int n_rows;          ///< below the triangle
  int parent;          ///< a later supernode, or -1
  size_t rows_offset;  ///< of its rows in SupernodalStructure::rows

  [[nodiscard]] int end_column() const { return first_column + n_columns; }
};

/// Pattern of the factor.
struct SupernodalStructure {
  std::vector<int> ordering;          ///< ordering[new] = old
  std::vector<Supernode> supernodes;  ///< postordered: a subtree is a range that ends with its root
  std::vector<int> rows;              ///< ascending new indices, supernode after supernode

  [[nodiscard]] const int* rows_of(const Supernode& s) const { return rows.data() + s.rows_offset; }
};

/// Time that a solve spends on a supernode, about in nanoseconds.
[[nodiscard]] double solve_cost(int n_columns, int n_rows);

/// Finds the supernodes. Few columns have exactly the same rows, so neighbours in the tree are joined (amalgamation) as
/// long as the zeros that this adds cost a solve less than another supernode.
///
/// @param pattern  symmetric, stored whole
/// @param ordering    fill-reducing, ordering[new] = old
[[nodiscard]] SupernodalStructure make_supernodes(const SparseMatrix& pattern, std::vector<int> ordering);

}  // namespace arap
