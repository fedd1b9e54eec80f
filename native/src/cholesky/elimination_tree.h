// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "sparse/sparse.h"

namespace arap {

/// Who waits for whom when A = L L^T is eliminated in a given order. The parent of column j is the row of the first
/// entry below the diagonal in column j of L; the entries of a column below its parent are a subset of the parent's.
/// Columns of different branches do not touch each other. [Liu 1990, "The role of elimination trees"]
struct EliminationTree {
  std::vector<int> order;   ///< order[new] = old, postordered: a subtree is a range that ends with its root
  std::vector<int> parent;  ///< of each new column; -1 for roots
  std::vector<int> count;   ///< entries of each column of L, the diagonal included
};

/// @param pattern  symmetric, stored whole
/// @param order    order[new] = old; equivalent orders have the same fill, the tree's is the postordered one
[[nodiscard]] EliminationTree make_elimination_tree(const SparseMatrix& pattern, std::vector<int> order);

/// Children before parents, the subtree of each node in one piece; children in ascending order. @param parent of nodes
[[nodiscard]] std::vector<int> postorder(const std::vector<int>& parent);

}  // namespace arap
