// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace arap {

/// The dense matrix of one supernode during the factorization: its columns and rows of what is left of A, lower
/// triangle, column-major. Columns and rows are padded to multiples of 4, the columns with those of the identity.
///
///     [ F11  .  ]   n_columns         L11 L11^T = F11
///     [ F21 F22 ]   the rows          L21 = F21 L11^-T,  update = F22 - L21 L21^T
struct Front {
  double* values;
  int stride;     ///< between columns; >= n_rows + kFrontSlack
  int n_columns;  ///< of F11, a multiple of 4
  int n_rows;     ///< of F11 and F21, a multiple of 4
  /// (n_columns / 4, 16) set by the factorization: the inverses of the triangular 4 x 4 blocks on the diagonal,
  /// row-major
  double* inverses;
};

/// Vectors of rows may reach over the last one.
inline constexpr int kFrontSlack = 16;

/// Columns that are factorized together, before the rest sees them.
inline constexpr int kFrontPanel = 32;

/// Rows that store_tiles works on together: ranges for different threads begin at multiples of it.
inline constexpr int kFrontRowBlock = 16;

struct FrontKernels {
  /// Factorizes the columns [begin, end) of F11 and F21; what is left of them is up to date. The upper triangle of F11
  /// becomes 0 in the diagonal blocks. Returns false where a pivot is not larger than its bound.
  /// @param least_pivot  (n_columns,)
  bool (*factor_panel)(const Front& front, int begin, int end, const double* least_pivot);

  /// Subtracts the products of the columns [begin, end) from the columns [target_begin, target_end), which come later;
  /// all multiples of 4.
  void (*update_columns)(const Front& front, int begin, int end, int target_begin, int target_end);

  /// Stores the strips of rows [begin, end) of G = [L11^-1; -L21 L11^-1] as tiles (tile_kernels.h). Returns false where
  /// a number is too large for the format.
  /// @param n_own       columns that are not padding; the others become 0
  /// @param n_own_rows  rows of F21 that are not padding
  /// @param workspace   (kFrontRowBlock + 1, n_columns)
  /// @param tiles       of the supernode
  bool (*store_tiles)(const Front& front, int n_own, int n_own_rows, int begin, int end, double* workspace,
                      void* tiles);

  /// The same as halves; null where the instruction set does not convert them. What one row loses by rounding the next
  /// one gets, so that sums down the columns stay right: smooth vectors, the ones that solves are about, see hardly any
  /// rounding.
  bool (*store_half_tiles)(const Front& front, int n_own, int n_own_rows, int begin, int end, double* workspace,
                           void* tiles);
};

}  // namespace arap
