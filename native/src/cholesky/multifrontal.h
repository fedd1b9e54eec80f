// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "cholesky/tile_plan.h"
#include "kernels/kernels.h"
#include "parallel/meter.h"
#include "sparse/sparse.h"

namespace arap {

/// Of the front of a supernode.
struct FrontSize {
  explicit FrontSize(const Supernode& node);

  [[nodiscard]] size_t n_values() const { return static_cast<size_t>(stride) * static_cast<size_t>(n_rows); }

  int n_columns;
  int n_rows;
  int stride;
};

/// About the memory that a factorization takes while it is made by one thread: the factor, the largest front, and the
/// update matrices that are there at once.
/// @param tile_number_bytes  of a number in the factor
[[nodiscard]] double factorization_bytes(const TilePlan& plan, size_t tile_number_bytes);

/// What a factorization needs of the pattern beside the TilePlan: where each number goes.
///
/// The multifrontal method [Liu 1992]: the front of a supernode is a small dense matrix (front_kernels.h). It collects
/// the entries of A in its columns and the update matrices of its children. Eliminating its columns leaves an update
/// matrix for its parent. All arithmetic is dense; only the assembly is sparse.
struct FrontPlan {
  FrontPlan(const SparseMatrix& pattern, const TilePlan& plan);

  struct Entry {
    int source;  ///< in the values of A
    int row;     ///< of the front
  };

  std::vector<int> entry_offsets;  ///< (n + 1,) of each column, in the factor's ordering
  std::vector<Entry> entries;      ///< of the lower triangle
  std::vector<int> parent_rows;    ///< for each entry of SupernodalStructure::rows its row in the parent's front
  std::vector<int> first_child;    ///< of each supernode, or -1
  std::vector<int> next_sibling;
};

/// Scales the rows and columns of A before the factorization, so that all numbers are near 1. Powers of two: they
/// change no digits.
struct Scaling {
  /// @param is_erased  (n,) rows and columns to ignore
  Scaling(const SparseMatrix& A, const std::vector<char>& is_erased);

  double of_all = 1;           ///< common factor
  std::vector<float> of_each;  ///< factor of each unknown, 0 if it is erased
};

/// Factorizes the scaled A with rows and columns of erased unknowns replaced by those of the identity. Throws
/// SolverError if that is not positive definite. Returns false if a number is too large for the format.
/// @param tiles  (16 * number of tiles,) output
bool factorize_multifrontal(const TilePlan& plan, const FrontPlan& fronts, const Workers& workers,
                            const FrontKernels& kernels, const SparseMatrix& A, const Scaling& scaling,
                            TileFormat format, std::byte* tiles, const MeterPart& meter);

}  // namespace arap
