// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Kernel sources include this header: no inline functions of other headers here, see simd.h.

namespace arap {

inline constexpr int kSliceWidth = 16;

/// Sliced ELLPACK: rows of different lengths, sixteen side by side. Entry e of row 16 s + k is lane k of group
/// offsets[s] + e, so that a vector register holds the same entry of neighbouring rows. Shorter rows are padded with
/// zeros.
template <class Real>
struct SlicedView {
  const int* offsets;  ///< (n_slices + 1,)
  const int* indices;  ///< (n_groups, 16)
  const Real* values;  ///< (n_groups, 16)
};

/// The same with vectors as values: single precision reads the high part, double adds the low one, see SplitVector.
struct SplitView {
  const int* offsets;  ///< (n_slices + 1,)
  const int* indices;  ///< (n_groups, 16)
  const float* high;   ///< (n_groups, 3, 16)
  const short* low;    ///< (n_groups, 3, 16)  NOLINT(google-runtime-int): no <cstdint>
};

/// Type of stored coordinates. Differences of floats would leave three digits to an edge of a dense mesh, so the single
/// precision passes store 32 bits of fixed point: exact differences, and half the size of doubles.
template <class Real>
struct CoordinateOf;
template <>
struct CoordinateOf<double> {
  using Type = double;
};
template <>
struct CoordinateOf<float> {
  using Type = int;  ///< kFixedPointUnits units from -range to 0, and as many from 0 to range
};
template <class Real>
using Coordinate = typename CoordinateOf<Real>::Type;

inline constexpr double kFixedPointUnits = 0x1p30;

template <class Real>
struct PositionsView {
  const Coordinate<Real>* rows;  ///< (n_vertices, 4), the fourth component is ignored
  Real unit;                     ///< length of one unit of a coordinate; 1 for doubles
};

/// The term of volumes: k sum_c V_c (J_c - 1)^2 with J_c = det F_c, Q_c = 2 V_c F_c. Minus its gradient is
/// sum_c P_c q_cj with P_c = -k (J_c - 1) cof F_c.
template <class Real>
struct VolumeView {
  const Real* double_volumes;  ///< (n_cells,) 2 V_c
  Real stiffness;              ///< k
  Real* stresses;              ///< (n_cells, 3, 4) the rows of P_c, each with a 0; null: there is no such term
};

/// The passes of an iteration over a range of slices. Differences of positions are exact; all else is in Real.
template <class Real>
struct CellKernels {
  /// Stores n rows of 3 doubles as n rows of 4 coordinates between -range and range. Returns the largest |coordinate|,
  /// NaN if one is not finite. If it is above `range`, the stored values are meaningless.
  double (*store_positions)(const double* positions, int n, double range, Coordinate<Real>* rows);

  /// Local step of the cells in slices [begin, end): sets each rotation to the maximizer of <R_c, Q_c(p')>, starting
  /// from its present value. Returns the sum of <R_c, Q_c>, less the term of volumes, whose stresses it finds.
  /// @param cells       row: cell, index: vertex, values: q_cj; without the cell's home
  /// @param homes       of each row
  /// @param rotations   (n_cells, 4), unit quaternions, (x, y, z, w)
  double (*fit_rotations)(const SplitView& cells, const int* homes, const PositionsView<Real>& positions,
                          const VolumeView<Real>& volumes, Real* rotations, int begin, int end);

  /// The same for given rotations.
  double (*alignment)(const SplitView& cells, const int* homes, const PositionsView<Real>& positions,
                      const VolumeView<Real>& volumes, const Real* rotations, int begin, int end);

  /// Sets residual = b - K p' of the vertices in slices [begin, end), b_j = sum_c (R_c + P_c) q_cj. Returns their share
  /// of 1/2 <p', K p'>.
  /// @param incidences    row: vertex, index: cell, values: q_cj
  /// @param off_diagonals row: vertex j, index: vertex k other than j, value: -K_jk
  /// @param stresses      (n_cells, 3, 4), or null: none
  /// @param residual      (n_vertices, 3)
  double (*residual)(const SplitView& incidences, const SlicedView<Real>& off_diagonals,
                     const PositionsView<Real>& positions, const Real* rotations, const Real* stresses,
                     double* residual, int n_vertices, int begin, int end);
};

/// Control points that a cube has: three along each axis. Control point (x, y, z) is number 9 x + 3 y + z.
inline constexpr int kControlPoints = 27;

/// Cells over cubes with control points, one a control point, see CubeCells.
template <class Real>
struct CubeView {
  const int* control_points;  ///< (n_cubes, 27)
  const Real* weights;        ///< (n_cubes,)
  const int* offsets;         ///< of each control point's slots, and the end; filled up to whole slices
  const int* slots;           ///< kCubeSlots * cube + number, of a control point
};

inline constexpr int kCubeSlots = 32;

/// The passes of an iteration over CubeCells: from control points to cubes to cells, and back. Cubes have the columns
/// of a 3 x 3 matrix each, filled up to four: (n_cubes, 3, 4), and so have control points. Ranges are of cubes where
/// that is said, or of slices of control points.
template <class Real>
struct CubeKernels {
  /// weight_e times the cube's size times its deformation gradient, of cubes [begin, end).
  void (*gradients)(const CubeView<Real>& cubes, const PositionsView<Real>& positions, Real* gradients, int begin,
                    int end);
  /// As CellKernels::fit_rotations.
  double (*fit_rotations)(const CubeView<Real>& cubes, const Real* gradients, const VolumeView<Real>& volumes,
                          Real* rotations, int begin, int end);
  /// As CellKernels::alignment.
  double (*alignment)(const CubeView<Real>& cubes, const Real* gradients, const VolumeView<Real>& volumes,
                      const Real* rotations, int begin, int end);
  /// R_c + P_c of control points.
  void (*turns)(const Real* rotations, const Real* stresses, Real* turns, int begin, int end);
  /// weight_e times the mean of the turns, of cubes [begin, end).
  void (*mean_turns)(const CubeView<Real>& cubes, const Real* turns, Real* means, int begin, int end);
  /// As CellKernels::residual.
  double (*residual)(const CubeView<Real>& cubes, const Real* means, const SlicedView<Real>& off_diagonals,
                     const PositionsView<Real>& positions, double* residual, int n_vertices, int begin, int end);
};

}  // namespace arap
