// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace arap {

/// The dense matrix of one supernode during the factorization: lower triangle, column-major. Columns and rows are
/// padded to multiples of 4, the columns with columns of the identity.
///
///     [ F11  .  ]   n_columns         L11 L11^T = F11
///     [ F21 F22 ]   the rows          L21 = F21 L11^-T,  update = F22 - L21 L21^T
struct Front {
  double* values;
  int stride;     ///< between columns; >= n_rows + kFrontSlack
  int n_columns;  ///< of F11, a multiple of 4
  int n_rows;     ///< of F11 and F21, a multiple of 4
  /// (n_columns / 4, 16) output: inverses of the triangular 4 x 4 diagonal blocks, row-major
  double* inverses;
};

/// Vector loads and stores may reach this far beyond the last row.
inline constexpr int kFrontSlack = 16;

/// Columns that are factorized before the others are updated.
inline constexpr int kFrontPanel = 32;

/// Rows that store_tiles processes at a time; ranges of threads begin at multiples of it.
inline constexpr int kFrontRowBlock = 16;

struct FrontKernels {
  /// Factorizes the columns [begin, end) of F11 and F21, which must be updated by the columns before. Sets the upper
  /// triangles of the diagonal blocks to 0. Returns false if a pivot is not larger than its bound.
  /// @param least_pivot  (n_columns,)
  bool (*factor_panel)(const Front& front, int begin, int end, const double* least_pivot);

  /// Updates the later columns [target_begin, target_end) by the factorized columns [begin, end); all multiples of 4.
  void (*update_columns)(const Front& front, int begin, int end, int target_begin, int target_end);

  /// Stores the rows [begin, end) of G = [L11^-1; -L21 L11^-1] as tiles (tile_kernels.h). Returns false if a number is
  /// too large for the format.
  /// @param n_own       columns that are not padding; padding is stored as 0
  /// @param n_own_rows  rows of F21 that are not padding
  /// @param workspace   (kFrontRowBlock + 1, n_columns)
  /// @param tiles       of the supernode
  bool (*store_tiles)(const Front& front, int n_own, int n_own_rows, int begin, int end, double* workspace,
                      void* tiles);

  /// The same in half precision; null if the instruction set cannot convert. The rounding error of a row is carried to
  /// the next one (error diffusion), so column sums stay right: smooth vectors, which matter most, see hardly any
  /// rounding.
  bool (*store_half_tiles)(const Front& front, int n_own, int n_own_rows, int begin, int end, double* workspace,
                           void* tiles);
};

}  // namespace arap
