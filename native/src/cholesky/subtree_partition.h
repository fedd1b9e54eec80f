// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

/// About three subtrees a thread, so that a thread that loses its core does not stop the others. For one thread: one
/// subtree and no root part.
[[nodiscard]] SubtreePartition make_partition(const SupernodalStructure& structure, int n_threads);

}  // namespace arap
