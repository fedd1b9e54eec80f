// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Included where the flags are of one instruction set: no header with inline functions may come in here, or the linker
// could hand their copies to code that has to run on every processor.

namespace arap {

inline constexpr int kSliceWidth = 16;

/// Ragged rows, sixteen at a time side by side ("sliced ELLPACK"): entry e of row 16 s + k belongs to group offsets[s]
/// + e and is its lane k, so that one vector register takes the same entry of neighbouring rows. Shorter rows are
/// filled with zeros.
template <class Real>
struct SlicedView {
  const int* offsets;  ///< n_slices + 1
  const int* indices;  ///< 16 of each group
  const Real* values;  ///< 16 of each component of each group
};

/// Differences of positions must not be of rounded numbers: in single precision an edge of a dense mesh would have
/// three digits left. Beside doubles stand 32 bits of fixed point, whose differences are exact and which take half the
/// room.
template <class Real>
struct CoordinateOf;
template <>
struct CoordinateOf<double> {
  using Type = double;
};
template <>
struct CoordinateOf<float> {
  using Type = int;  ///< of kFixedPointUnits units from -range to 0, and as many above
};
template <class Real>
using Coordinate = typename CoordinateOf<Real>::Type;

inline constexpr double kFixedPointUnits = 0x1p30;

template <class Real>
struct PositionsView {
  const Coordinate<Real>* rows;  ///< (n_vertices, 4), the fourth of any value
  Real unit;                     ///< of a coordinate; 1 for doubles
};

/// The two passes of an iteration over a range of slices, compiled once per instruction set. Differences of positions
/// are exact; everything after that is Real.
template <class Real>
struct CellKernels {
  /// Stores n rows of 3 as n rows of 4, for coordinates between -range and range. Returns the largest |coordinate|, NaN
  /// if one is not finite; where that is above the range, what is stored is of no use.
  double (*store_positions)(const double* positions, int n, double range, Coordinate<Real>* rows);

  /// Local step of the cells in slices [begin, end): each rotation becomes the one that maximizes <R_c, Q_c(p')>,
  /// starting from its present value; returns the sum of <R_c, Q_c>.
  /// @param cells       row: cell, index: vertex, 3 components: q_cj; without the vertex in `references`
  /// @param references  of each row: one vertex of the cell
  /// @param rotations   (n_cells, 4), unit quaternions, (x, y, z, w)
  double (*fit_rotations)(const SlicedView<Real>& cells, const int* references, const PositionsView<Real>& positions,
                          Real* rotations, int begin, int end);

  /// The sum of <R_c, Q_c> for the rotations as they are.
  double (*alignment)(const SlicedView<Real>& cells, const int* references, const PositionsView<Real>& positions,
                      const Real* rotations, int begin, int end);

  /// residual = b - K p' of the vertices in slices [begin, end), b_j = sum_c R_c q_cj; returns their part of
  /// 1/2 <p', K p'>.
  /// @param incidences  row: vertex, index: cell, 3 components: q_cj
  /// @param springs     row: vertex j, index: vertex k other than j, 1 component: -K_jk
  /// @param residual    (n_vertices, 3)
  double (*residual)(const SlicedView<Real>& incidences, const SlicedView<Real>& springs,
                     const PositionsView<Real>& positions, const Real* rotations, double* residual, int n_vertices,
                     int begin, int end);
};

}  // namespace arap
