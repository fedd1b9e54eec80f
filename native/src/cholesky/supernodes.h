// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "sparse/sparse.h"

namespace arap {

/// Consecutive columns of L that share their rows: a dense trapezoid, a triangle of n_columns over n_rows more rows.
struct Supernode {
  int first_column;
  int n_columns;
  int n_rows;          ///< below the triangle
  int parent;          ///< a later supernode, or -1
  size_t rows_offset;  ///< of its rows in SupernodalStructure::rows

  [[nodiscard]] int end_column() const { return first_column + n_columns; }
};

/// Where the factor of a matrix has entries.
struct SupernodalStructure {
  std::vector<int> order;             ///< order[new] = old
  std::vector<Supernode> supernodes;  ///< postordered: a subtree is a range that ends with its root
  std::vector<int> rows;              ///< ascending new indices, supernode after supernode

  [[nodiscard]] const int* rows_of(const Supernode& s) const { return rows.data() + s.rows_offset; }
};

/// What a solve spends on a supernode, in units of about a nanosecond.
[[nodiscard]] double solve_cost(int n_columns, int n_rows);

/// Finds the supernodes. Columns that have exactly the same rows are few; neighbours in the tree are joined as long as
/// the zeros that this stores cost a solve less than one more supernode does.
///
/// @param pattern  symmetric, stored whole
/// @param order    fill-reducing, order[new] = old
[[nodiscard]] SupernodalStructure make_supernodes(const SparseMatrix& pattern, std::vector<int> order);

}  // namespace arap
