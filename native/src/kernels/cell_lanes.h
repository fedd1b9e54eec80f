// SPDX-License-Identifier: GPL-3.0-or-later
// What the passes over cells have in common, in lanes: fits of rotations, volumes, forces of K. For kernel sources
// only, see simd.h.
#pragma once

#include "geometry/fit_quaternion.h"
#include "kernels/cell_kernels.h"
#include "kernels/lanes.h"

namespace arap {
namespace {

template <class Real>
using Quaternion = Four<Real>;  // x, y, z, w

template <class Real>
struct Matrix {
  Three<Real> rows[3];  // NOLINT: no std::array here, see simd.h
  [[gnu::always_inline]] Three<Real>& operator[](int i) { return rows[i]; }
  [[gnu::always_inline]] const Three<Real>& operator[](int i) const { return rows[i]; }
};

/// When a fit ends. A Newton step by the angle t (radians) leaves an error of about t^3.
template <class Real>
struct FitLimits;
template <>
struct FitLimits<double> {
  static constexpr double kLastTurnSquared = 1e-10;
  static constexpr double kLeastDefinite = 1e-6;  // relative to the norm of Q
};
template <>
struct FitLimits<float> {
  static constexpr float kLastTurnSquared = 1e-5F;
  static constexpr float kLeastDefinite = 1e-4F;
};

/// Offset of a group's lanes.
inline std::ptrdiff_t lanes_of(int group, int n_components) {
  return static_cast<std::ptrdiff_t>(group) * n_components * kSliceWidth;
}

/// Stored coordinates: vectors of Real hold their bits.
template <class Real>
using StoredRows = Four<Real>;

/// Loads row row_of(k) into lane k.
template <class Real, class RowOf>
[[gnu::always_inline]] inline StoredRows<Real> stored_rows(const Coordinate<Real>* rows, const RowOf& row_of) {
  return components<Real>([&](int k) __attribute__((always_inline)) {
    return __builtin_bit_cast(Vector<Real, 4>,
                              load<Coordinate<Real>, 4>(rows + 4 * static_cast<std::ptrdiff_t>(row_of(k))));
  });
}

/// a - b, exact but for the final rounding to Real.
template <class Real>
[[gnu::always_inline]] inline Three<Real> differences(const StoredRows<Real>& a, const StoredRows<Real>& b) {
  Three<Real> result{};
  for (int i = 0; i < 3; ++i) {
    if constexpr (sizeof(Real) == sizeof(double)) {
      result[i] = a[i] - b[i];
    } else {
      using Integers = Vector<int, kLaneCount<float>>;
      result[i] = __builtin_convertvector(__builtin_bit_cast(Integers, a[i]) - __builtin_bit_cast(Integers, b[i]),
                                          Lanes<float>);
    }
  }
  return result;
}

/// R - I.
template <class Real>
[[gnu::always_inline]] inline Matrix<Real> turn_matrix(const Quaternion<Real>& q) {
  const Lanes<Real> x2 = q[0] + q[0];
  const Lanes<Real> y2 = q[1] + q[1];
  const Lanes<Real> z2 = q[2] + q[2];
  const Lanes<Real> xx = q[0] * x2;
  const Lanes<Real> yy = q[1] * y2;
  const Lanes<Real> zz = q[2] * z2;
  const Lanes<Real> xy = q[0] * y2;
  const Lanes<Real> xz = q[0] * z2;
  const Lanes<Real> yz = q[1] * z2;
  const Lanes<Real> wx = q[3] * x2;
  const Lanes<Real> wy = q[3] * y2;
  const Lanes<Real> wz = q[3] * z2;
  return {{{-yy - zz, xy - wz, xz + wy}, {xy + wz, -xx - zz, yz - wx}, {xz - wy, yz + wx, -xx - yy}}};
}

template <class Real>
[[gnu::always_inline]] inline Matrix<Real> to_matrix(const Quaternion<Real>& q) {
  Matrix<Real> R = turn_matrix<Real>(q);
  for (int i = 0; i < 3; ++i) R[i][i] += broadcast<Real>(1);
  return R;
}

template <class Real>
[[gnu::always_inline]] inline Lanes<Real> inner_product(const Matrix<Real>& a, const Matrix<Real>& b) {
  Lanes<Real> sum = a[0][0] * b[0][0];
  for (int i = 1; i < 9; ++i) sum += a[i / 3][i % 3] * b[i / 3][i % 3];
  return sum;
}

/// q * (1, w / 2), normalized: the Cayley transform of w / 2 as a quaternion.
template <class Real>
[[gnu::always_inline]] inline Quaternion<Real> turned(const Quaternion<Real>& q, const Three<Real>& w) {
  const Lanes<Real> half = broadcast<Real>(0.5);
  const Lanes<Real> x = half * w[0];
  const Lanes<Real> y = half * w[1];
  const Lanes<Real> z = half * w[2];
  const Quaternion<Real> r{{q[0] + q[3] * x + q[1] * z - q[2] * y, q[1] + q[3] * y + q[2] * x - q[0] * z,
                            q[2] + q[3] * z + q[0] * y - q[1] * x, q[3] - q[0] * x - q[1] * y - q[2] * z}};
  const Lanes<Real> scale =
      broadcast<Real>(1) / square_root<Real>(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  return {{r[0] * scale, r[1] * scale, r[2] * scale, r[3] * scale}};
}

template <class Real>
struct NewtonStep {
  Three<Real> turn;
  Lanes<Real> turn_squared;
  Mask<Real> is_definite;
};

/// A step of refine_rotation() in rotation.cpp. With M = R^T Q:  H = tr(M) I - sym(M),  H turn = vee(M - M^T).
template <class Real>
[[gnu::always_inline]] inline NewtonStep<Real> newton_step(const Matrix<Real>& Q, const Quaternion<Real>& q,
                                                           const Lanes<Real>& least_pivot) {
  const Matrix<Real> R = to_matrix<Real>(q);
  Matrix<Real> M{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) M[i][j] = R[0][i] * Q[0][j] + R[1][i] * Q[1][j] + R[2][i] * Q[2][j];
  const Lanes<Real> one = broadcast<Real>(1);
  const Lanes<Real> minus_half = broadcast<Real>(-0.5);
  const Lanes<Real> d0 = M[1][1] + M[2][2];
  const Lanes<Real> over_d0 = one / d0;
  const Lanes<Real> h10 = minus_half * (M[1][0] + M[0][1]);
  const Lanes<Real> h20 = minus_half * (M[2][0] + M[0][2]);
  const Lanes<Real> h21 = minus_half * (M[2][1] + M[1][2]);
  const Lanes<Real> l1 = h10 * over_d0;
  const Lanes<Real> l2 = h20 * over_d0;
  const Lanes<Real> d1 = M[0][0] + M[2][2] - l1 * h10;
  const Lanes<Real> over_d1 = one / d1;
  const Lanes<Real> l21 = (h21 - l2 * h10) * over_d1;
  const Lanes<Real> d2 = M[0][0] + M[1][1] - l2 * h20 - l21 * l21 * d1;
  const Lanes<Real> y0 = M[2][1] - M[1][2];
  const Lanes<Real> y1 = M[0][2] - M[2][0] - l1 * y0;
  const Lanes<Real> y2 = M[1][0] - M[0][1] - l2 * y0 - l21 * y1;
  NewtonStep<Real> step{};
  step.turn[2] = y2 / d2;
  step.turn[1] = y1 * over_d1 - l21 * step.turn[2];
  step.turn[0] = y0 * over_d0 - l1 * step.turn[1] - l2 * step.turn[2];
  step.turn_squared = step.turn[0] * step.turn[0] + step.turn[1] * step.turn[1] + step.turn[2] * step.turn[2];
  step.is_definite = (d0 > least_pivot) & (d1 > least_pivot) & (d2 > least_pivot);
  return step;
}

/// The exact fit of one lane.
template <class Real>
[[gnu::noinline]] void fit_lane(const Matrix<Real>& Q, Quaternion<Real>& q, int k) {
  double S[9];       // NOLINT
  double former[4];  // NOLINT
  double fitted[4];  // NOLINT
  for (int i = 0; i < 9; ++i) S[i] = static_cast<double>(Q[i / 3][i % 3][k]);
  for (int i = 0; i < 4; ++i) former[i] = static_cast<double>(q[i][k]);
  fit_quaternion(S, former, fitted);
  for (int i = 0; i < 4; ++i) q[i][k] = static_cast<Real>(fitted[i]);
}

template <class Real>
[[gnu::always_inline]] inline Quaternion<Real> fitted(const Matrix<Real>& Q, const Quaternion<Real>& former) {
  constexpr int kMostSteps = 4;
  constexpr Real kLargestTurn = 1;  // radian
  const Lanes<Real> least_pivot =
      broadcast<Real>(FitLimits<Real>::kLeastDefinite) * square_root<Real>(inner_product<Real>(Q, Q));
  Quaternion<Real> q = former;
  Mask<Real> is_certain{};
  for (int i = 0; i < kMostSteps; ++i) {
    NewtonStep<Real> step = newton_step<Real>(Q, q, least_pivot);
    // Lanes without a certificate get the exact fit later; keep them finite until then.
    for (Lanes<Real>& component : step.turn.v) component = step.is_definite ? component : Lanes<Real>{};
    const Mask<Real> is_long = step.turn_squared > broadcast<Real>(kLargestTurn * kLargestTurn);
    if (bits<Real>(is_long) != 0) {
      const Lanes<Real> one = broadcast<Real>(1);
      const Lanes<Real> shrink =
          is_long ? broadcast<Real>(kLargestTurn) / square_root<Real>(is_long ? step.turn_squared : one) : one;
      for (Lanes<Real>& component : step.turn.v) component *= shrink;
    }
    q = turned<Real>(q, step.turn);
    is_certain = step.is_definite & (step.turn_squared <= broadcast<Real>(FitLimits<Real>::kLastTurnSquared));
    if (all<Real>(is_certain)) return q;
  }
  const unsigned certain = bits<Real>(is_certain);
  for (int k = 0; k < kLaneCount<Real>; ++k)
    if ((certain >> k & 1U) == 0) {
      for (int i = 0; i < 4; ++i) q[i][k] = former[i][k];
      fit_lane<Real>(Q, q, k);
    }
  return q;
}

/// <R, Q> for the rotation of q, corrected for the rounding of |q|. Computed from R - I: rounding of numbers near 1 has
/// one sign and would add up over many cells.
template <class Real>
[[gnu::always_inline]] inline Lanes<Real> aligned(const Quaternion<Real>& q, const Matrix<Real>& Q) {
  const Lanes<Real> turned = inner_product<Real>(turn_matrix<Real>(q), Q);
  const Lanes<Real> excess = q[3] * q[3] - broadcast<Real>(1) + q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
  return Q[0][0] + Q[1][1] + Q[2][2] + (turned - turned * excess);
}

template <class Real>
[[gnu::always_inline]] inline Quaternion<Real> load_rotations(const Real* rotations) {
  return components<Real>([&](int k) __attribute__((always_inline)) {
    return load<Real, 4>(rotations + std::ptrdiff_t{4} * k);
  });
}

/// Finds the stresses of the cells in a vector's lanes, `first` and those after it; returns k V (J - 1)^2.
template <class Real>
[[gnu::always_inline]] inline Lanes<Real> keep_volume(const Matrix<Real>& Q, const VolumeView<Real>& volumes,
                                                      std::ptrdiff_t first) {
  const Lanes<Real> one = broadcast<Real>(1);
  const auto double_volume = load<Real, kLaneCount<Real>>(volumes.double_volumes + first);
  const Mask<Real> is_solid = double_volume > broadcast<Real>(0);
  const Lanes<Real> inverse = is_solid ? one / (is_solid ? double_volume : one) : Lanes<Real>{};
  Matrix<Real> F{};
  for (int i = 0; i < 9; ++i) F[i / 3][i % 3] = Q[i / 3][i % 3] * inverse;
  Matrix<Real> cofactors{};
  for (int i = 0; i < 9; ++i) {
    const Three<Real>& next = F[(i / 3 + 1) % 3];
    const Three<Real>& last = F[(i / 3 + 2) % 3];
    cofactors[i / 3][i % 3] =
        next[(i % 3 + 1) % 3] * last[(i % 3 + 2) % 3] - next[(i % 3 + 2) % 3] * last[(i % 3 + 1) % 3];
  }
  const Lanes<Real> excess = F[0][0] * cofactors[0][0] + F[0][1] * cofactors[0][1] + F[0][2] * cofactors[0][2] - one;
  const Lanes<Real> pressure = broadcast<Real>(volumes.stiffness) * excess;
  for (int i = 0; i < 3; ++i)
    for_each_row<Real>(
        {{-pressure * cofactors[i][0], -pressure * cofactors[i][1], -pressure * cofactors[i][2], Lanes<Real>{}}},
        [&](int k, const Vector<Real, 4>& row) __attribute__((always_inline)) {
          store<Real, 4>(volumes.stresses + 12 * (first + k) + std::ptrdiff_t{4} * i, row);
        });
  return broadcast<Real>(0.5) * double_volume * pressure * excess;
}

/// Sets the rotations of the cells in a vector's lanes, `first` and those after it, to the maximizers of <R, Q>. Adds
/// <R, Q>, less the term of volumes, whose stresses it finds.
template <class Real>
[[gnu::always_inline]] inline void fit_cells(const Matrix<Real>& Q, const VolumeView<Real>& volumes, Real* rotations,
                                             std::ptrdiff_t first, LaneSum<Real>& sum) {
  Real* out = rotations + 4 * first;
  const Quaternion<Real> q = fitted<Real>(Q, load_rotations<Real>(out));
  for_each_row<Real>(
      q, [&](int k, const Vector<Real, 4>& row)
             __attribute__((always_inline)) { store<Real, 4>(out + std::ptrdiff_t{4} * k, row); });
  sum.add(aligned<Real>(q, Q));
  if (volumes.stresses != nullptr) sum.add(-keep_volume<Real>(Q, volumes, first));
}

/// Adds the same for given rotations.
template <class Real>
[[gnu::always_inline]] inline void align_cells(const Matrix<Real>& Q, const VolumeView<Real>& volumes,
                                               const Real* rotations, std::ptrdiff_t first, LaneSum<Real>& sum) {
  sum.add(aligned<Real>(load_rotations<Real>(rotations + 4 * first), Q));
  if (volumes.stresses != nullptr) sum.add(-keep_volume<Real>(Q, volumes, first));
}

/// Adds -K p' of the vertices in the lanes of a slice from `part` on to `sum`, and four times their share of
/// 1/2 <p', K p'> to `energy`.
template <class Real>
[[gnu::always_inline]] inline void add_stiffness(const SlicedView<Real>& off_diagonals,
                                                 const PositionsView<Real>& positions, int slice, int part,
                                                 Three<Real>& sum, LaneSum<Real>& energy) {
  const Lanes<Real> unit = broadcast<Real>(positions.unit);
  const int first = slice * kSliceWidth + part;
  const StoredRows<Real> own = stored_rows<Real>(
      positions.rows, [&](int k) __attribute__((always_inline)) { return first + k; });
  Three<Real> forces{};
  Lanes<Real> edge_energy{};
  for (int group = off_diagonals.offsets[slice]; group < off_diagonals.offsets[slice + 1]; ++group) {
    const int* index = off_diagonals.indices + lanes_of(group, 1) + part;
    const Three<Real> e =
        differences<Real>(stored_rows<Real>(
                              positions.rows, [&](int k) __attribute__((always_inline)) { return index[k]; }),
                          own);
    const auto w = load<Real, kLaneCount<Real>>(off_diagonals.values + lanes_of(group, 1) + part);
    for (int a = 0; a < 3; ++a) {
      const Lanes<Real> force = w * e[a];
      forces[a] += force;
      edge_energy += force * e[a];
    }
  }
  for (int a = 0; a < 3; ++a) sum[a] += unit * forces[a];
  energy.add(edge_energy * unit * unit);
}

/// Stores rows of three doubles; writes nothing behind the last row.
template <class Real>
[[gnu::always_inline]] inline void store_rows(const Three<Real>& components, int n_rows, double* rows) {
  for_each_row<Real>(
      {{components[0], components[1], components[2], Lanes<Real>{}}}, [&](int k,
                                                                          const Vector<Real, 4>&
                                                                              row) __attribute__((always_inline)) {
        if (k >= n_rows) return;
        const Vector<double, 4> wide = __builtin_convertvector(row, Vector<double, 4>);
        if (k + 1 < n_rows && k + 1 < kLaneCount<Real>)
          store<double, 4>(rows + std::ptrdiff_t{3} * k, wide);  // the next row overwrites the fourth number
        else
          for (int a = 0; a < 3; ++a) rows[std::ptrdiff_t{3} * k + a] = wide[a];
      });
}

}  // namespace
}  // namespace arap
