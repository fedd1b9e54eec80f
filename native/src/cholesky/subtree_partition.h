// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "cholesky/supernodes.h"

namespace arap {

/// Consecutive supernodes with all their descendants: nobody else writes to their columns during an elimination.
struct Branch {
  int begin;
  int end;
  double cost;
};

/// The elimination tree cut in branches, which threads take one by one, and the top above them.
struct Partition {
  std::vector<Branch> branches;  ///< the most work first
  std::vector<int> top;          ///< supernodes, ascending
};

/// About three branches a thread, so that a thread that lost its core for a while does not stop the others. One thread:
/// one branch and no top.
[[nodiscard]] Partition make_partition(const SupernodalStructure& structure, int n_threads);

}  // namespace arap
