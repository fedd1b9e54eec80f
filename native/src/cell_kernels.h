// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Included where the flags are of one instruction set: no header with inline functions may come in here, or the linker
// could hand their copies to code that has to run on every processor.

namespace arap {

inline constexpr int kSliceWidth = 8;

/// Ragged rows, eight at a time side by side ("sliced ELLPACK"): entry e of row 8 s + k belongs to group offsets[s] + e
/// and is its lane k, so that one vector register takes the same entry of neighbouring rows. Shorter rows are filled
/// with zeros.
struct SlicedView {
  const int* offsets;    ///< n_slices + 1
  const int* indices;    ///< 8 of each group
  const double* values;  ///< 8 of each component of each group
};

/// The two passes of an iteration over a range of slices, compiled once per instruction set.
struct CellKernels {
  /// Local step of the cells in slices [begin, end): each quaternion becomes the rotation that maximizes <R_c,
  /// Q_c(p')>, starting from its present value.
  /// @param cells        row: cell, index: vertex, 3 components: q_cj
  /// @param positions    (n_vertices, 4)
  /// @param quaternions  (n_cells, 4), unit, (x, y, z, w)
  void (*fit_rotations)(const SlicedView& cells, const double* positions, double* quaternions, int begin, int end);

  /// residual = b - K p' of the vertices in slices [begin, end), b_j = sum_c R_c q_cj; returns their part of
  /// 1/2 <p', K p'> - <p', b>.
  /// @param incidences  row: vertex, index: cell, 3 components: q_cj
  /// @param system      row: vertex, index: vertex, 1 component: K
  /// @param residual    (n_vertices, 3)
  double (*residual)(const SlicedView& incidences, const SlicedView& system, const double* positions,
                     const double* quaternions, double* residual, int n_vertices, int begin, int end);
};

/// The exact fit for what the kernels leave open: the rotation that maximizes <R, S>, S row by row, as a quaternion;
/// `former` is kept where S is 0.
void fit_quaternion(const double* S, const double* former, double* quaternion);

}  // namespace arap
