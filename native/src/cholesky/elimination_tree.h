// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "sparse/sparse.h"

namespace arap {

/// Elimination tree of A = L L^T [Liu 1990, "The role of elimination trees"]. The parent of column j is the row of the
/// first entry below the diagonal of column j of L. The entries of a column below its parent are a subset of the
/// parent's. Columns of disjoint subtrees do not depend on each other.
struct EliminationTree {
  std::vector<int> ordering;  ///< ordering[new] = old, postordered: a subtree is a range that ends with its root
  std::vector<int> parent;    ///< of each new column; -1 for roots
  std::vector<int> count;     ///< entries of each column of L, the diagonal included
};

/// @param pattern  symmetric, stored whole
/// @param ordering  ordering[new] = old; the tree has an equivalent ordering, postordered, with the same fill
[[nodiscard]] EliminationTree make_elimination_tree(const SparseMatrix& pattern, std::vector<int> ordering);

/// Nodes with children before parents, each subtree contiguous, children ascending.
/// @param parent  of each node, -1 for roots
[[nodiscard]] std::vector<int> postorder(const std::vector<int>& parent);

}  // namespace arap
