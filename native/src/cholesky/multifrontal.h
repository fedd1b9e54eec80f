// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "cholesky/tile_plan.h"
#include "kernels/kernels.h"
#include "sparse/sparse.h"

namespace arap {

/// Everything of a factorization that depends on the pattern alone, beside the TilePlan: where each number goes.
///
/// The multifrontal method [Liu 1992]: a supernode's front is a small dense matrix (front_kernels.h) that collects the
/// entries of A in its columns and the updates that its children leave. Eliminating its columns leaves its own update,
/// for its parent. All arithmetic is dense; what is sparse is only the adding up.
struct FrontPlan {
  FrontPlan(const SparseMatrix& pattern, const TilePlan& plan);

  struct Entry {
    int source;  ///< in the values of A
    int row;     ///< of the front
  };

  std::vector<int> entry_offsets;  ///< of each column in the factor's order, and the end
  std::vector<Entry> entries;      ///< of the lower triangle
  std::vector<int> parent_rows;    ///< for each of SupernodalStructure::rows, the row of the parent's front
  std::vector<int> first_child;    ///< of each supernode, or -1
  std::vector<int> next_sibling;
};

/// Rows and columns of A are multiplied by these before it is factorized, so that all numbers are near 1: powers of
/// two, which change no digits.
struct Scaling {
  /// @param is_erased  (n,) where A has no meaning
  Scaling(const SparseMatrix& A, const std::vector<char>& is_erased);

  double of_all = 1;           ///< times
  std::vector<float> of_each;  ///< of each unknown, 0 where it is erased
};

/// Factorizes A, scaled, with the rows and columns of erased unknowns replaced by those of the identity. Throws
/// SolverError where that is not positive definite. Returns false where a number does not fit in the format.
/// @param tiles  (16 * number of tiles,) set
bool factorize_multifrontal(const TilePlan& plan, const FrontPlan& fronts, const FrontKernels& kernels,
                            const SparseMatrix& A, const Scaling& scaling, TileFormat format, std::byte* tiles);

}  // namespace arap
