// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.

#include "cell_kernels.h"

#include "lanes.h"

namespace arap {

namespace {

struct Vector {
  Doubles v[3];  // NOLINT: no std::array here, see cell_kernels.h
  Doubles& operator[](int i) { return v[i]; }
  const Doubles& operator[](int i) const { return v[i]; }
};
using Quaternion = Four;  // x, y, z, w
struct Matrix {
  Vector rows[3];  // NOLINT
  Vector& operator[](int i) { return rows[i]; }
  const Vector& operator[](int i) const { return rows[i]; }
};

Matrix to_matrix(const Quaternion& q) {
  const Doubles x2 = q[0] + q[0];
  const Doubles y2 = q[1] + q[1];
  const Doubles z2 = q[2] + q[2];
  const Doubles xx = q[0] * x2;
  const Doubles yy = q[1] * y2;
  const Doubles zz = q[2] * z2;
  const Doubles xy = q[0] * y2;
  const Doubles xz = q[0] * z2;
  const Doubles yz = q[1] * z2;
  const Doubles wx = q[3] * x2;
  const Doubles wy = q[3] * y2;
  const Doubles wz = q[3] * z2;
  const Doubles one = broadcast(1.0);
  Matrix R;
  R[0] = {one - yy - zz, xy - wz, xz + wy};
  R[1] = {xy + wz, one - xx - zz, yz - wx};
  R[2] = {xz - wy, yz + wx, one - xx - yy};
  return R;
}

/// q * (1, w / 2), normalized: the Cayley transform of w / 2 as a quaternion.
Quaternion turned(const Quaternion& q, const Vector& w) {
  const Doubles half = broadcast(0.5);
  const Doubles x = half * w[0];
  const Doubles y = half * w[1];
  const Doubles z = half * w[2];
  const Quaternion r{q[0] + q[3] * x + q[1] * z - q[2] * y, q[1] + q[3] * y + q[2] * x - q[0] * z,
                     q[2] + q[3] * z + q[0] * y - q[1] * x, q[3] - q[0] * x - q[1] * y - q[2] * z};
  const Doubles scale = broadcast(1.0) / square_root(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  return {r[0] * scale, r[1] * scale, r[2] * scale, r[3] * scale};
}

/// Start of a group's lanes.
long lanes_of(int group, int n_components) { return static_cast<long>(group) * n_components * kSliceWidth; }

struct NewtonStep {
  Vector turn;
  Doubles turn_squared;
  Mask is_definite;
};

/// See refine_rotation() in rotation.cpp, whose steps these are. With M = R^T Q:  H = tr(M) I - sym(M),  H turn = vee(M
/// - M^T).
NewtonStep newton_step(const Matrix& Q, const Quaternion& q, const Doubles& least_pivot) {
  const Matrix R = to_matrix(q);
  Matrix M;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) M[i][j] = R[0][i] * Q[0][j] + R[1][i] * Q[1][j] + R[2][i] * Q[2][j];
  const Doubles minus_half = broadcast(-0.5);
  const Doubles d0 = M[1][1] + M[2][2];
  const Doubles h10 = minus_half * (M[1][0] + M[0][1]);
  const Doubles h20 = minus_half * (M[2][0] + M[0][2]);
  const Doubles h21 = minus_half * (M[2][1] + M[1][2]);
  const Doubles l1 = h10 / d0;
  const Doubles l2 = h20 / d0;
  const Doubles d1 = M[0][0] + M[2][2] - l1 * h10;
  const Doubles l21 = (h21 - l2 * h10) / d1;
  const Doubles d2 = M[0][0] + M[1][1] - l2 * h20 - l21 * l21 * d1;
  const Doubles y0 = M[2][1] - M[1][2];
  const Doubles y1 = M[0][2] - M[2][0] - l1 * y0;
  const Doubles y2 = M[1][0] - M[0][1] - l2 * y0 - l21 * y1;
  NewtonStep step;
  step.turn[2] = y2 / d2;
  step.turn[1] = y1 / d1 - l21 * step.turn[2];
  step.turn[0] = y0 / d0 - l1 * step.turn[1] - l2 * step.turn[2];
  step.turn_squared = step.turn[0] * step.turn[0] + step.turn[1] * step.turn[1] + step.turn[2] * step.turn[2];
  step.is_definite = (d0 > least_pivot) & (d1 > least_pivot) & (d2 > least_pivot);
  return step;
}

/// The exact fit of one lane.
void fit_lane(const Matrix& Q, const double* former, double* quaternion, int k) {
  double S[9];  // NOLINT
  for (int i = 0; i < 9; ++i) S[i] = Q[i / 3][i % 3][k];
  fit_quaternion(S, former, quaternion);
}

void fit_lanes(const Matrix& Q, double* quaternions) {
  constexpr int kMostSteps = 4;
  constexpr double kLastTurnSquared = 1e-14;  // radians squared; Newton squares the error once more
  constexpr double kLeastDefinite = 1e-6;     // relative
  constexpr double kLargestTurn = 1.0;        // radians
  Doubles norm_squared = broadcast(0.0);
  for (const Vector& row : Q.rows)
    for (const Doubles& value : row.v) norm_squared += value * value;
  const Doubles least_pivot = broadcast(kLeastDefinite) * square_root(norm_squared);

  Quaternion q = load_rows(quaternions);
  Mask is_certain{};
  for (int i = 0; i < kMostSteps; ++i) {
    NewtonStep step = newton_step(Q, q, least_pivot);
    const Doubles limit = broadcast(kLargestTurn * kLargestTurn);
    const Doubles shrink =
        select(step.turn_squared > limit, broadcast(kLargestTurn) / square_root(step.turn_squared), broadcast(1.0));
    for (Doubles& component : step.turn.v) component = component * shrink;
    // Lanes without a certificate go to the exact fit; until then they must stay finite.
    for (Doubles& component : step.turn.v) component = select(step.is_definite, component, broadcast(0.0));
    q = turned(q, step.turn);
    is_certain = step.is_definite & (step.turn_squared <= broadcast(kLastTurnSquared));
    if (all(is_certain)) break;
  }
  for (int k = 0; k < kLanes; ++k) {
    if (is_lane(is_certain, k)) {
      for (int a = 0; a < 4; ++a) quaternions[4 * k + a] = q[a][k];
    } else {
      fit_lane(Q, quaternions + 4 * k, quaternions + 4 * k, k);
    }
  }
}

void fit_rotations(const SlicedView& cells, const double* positions, double* quaternions, int begin, int end) {
  for (int slice = begin; slice < end; ++slice)
    for (int part = 0; part < kSliceWidth; part += kLanes) {
      Matrix Q{};
      for (int group = cells.offsets[slice]; group < cells.offsets[slice + 1]; ++group) {
        const Four p = gather_rows(positions, cells.indices + lanes_of(group, 1) + part);
        const double* values = cells.values + lanes_of(group, 3) + part;
        for (int j = 0; j < 3; ++j) {
          const Doubles q = load(values + j * kSliceWidth);
          for (int i = 0; i < 3; ++i) Q[i][j] += p[i] * q;
        }
      }
      fit_lanes(Q, quaternions + 4 * static_cast<long>(slice * kSliceWidth + part));
    }
}

double find_residual(const SlicedView& incidences, const SlicedView& system, const double* positions,
                     const double* quaternions, double* residual, int n_vertices, int begin, int end) {
  Doubles energy = broadcast(0.0);
  for (int slice = begin; slice < end; ++slice)
    for (int part = 0; part < kSliceWidth; part += kLanes) {
      Vector b{};
      for (int group = incidences.offsets[slice]; group < incidences.offsets[slice + 1]; ++group) {
        const Quaternion r = gather_rows(quaternions, incidences.indices + lanes_of(group, 1) + part);
        const double* values = incidences.values + lanes_of(group, 3) + part;
        const Vector v{load(values), load(values + kSliceWidth), load(values + 2 * kSliceWidth)};
        // R v = v + w t + u x t with t = 2 u x v, u = (x, y, z).
        const Vector half{r[1] * v[2] - r[2] * v[1], r[2] * v[0] - r[0] * v[2], r[0] * v[1] - r[1] * v[0]};
        const Vector t{half[0] + half[0], half[1] + half[1], half[2] + half[2]};
        b[0] += v[0] + r[3] * t[0] + (r[1] * t[2] - r[2] * t[1]);
        b[1] += v[1] + r[3] * t[1] + (r[2] * t[0] - r[0] * t[2]);
        b[2] += v[2] + r[3] * t[2] + (r[0] * t[1] - r[1] * t[0]);
      }
      Vector Kp{};
      for (int group = system.offsets[slice]; group < system.offsets[slice + 1]; ++group) {
        const Four p = gather_rows(positions, system.indices + lanes_of(group, 1) + part);
        const Doubles value = load(system.values + lanes_of(group, 1) + part);
        for (int a = 0; a < 3; ++a) Kp[a] += value * p[a];
      }
      const int first = slice * kSliceWidth + part;
      const Four p = load_rows(positions + 4 * static_cast<long>(first));
      const Doubles half = broadcast(0.5);
      for (int a = 0; a < 3; ++a) {
        energy += p[a] * (half * Kp[a] - b[a]);
        const Doubles difference = b[a] - Kp[a];
        for (int k = 0; k < kLanes && first + k < n_vertices; ++k)
          residual[3 * static_cast<long>(first + k) + a] = difference[k];
      }
    }
  double sum = 0;
  for (int k = 0; k < kLanes; ++k) sum += energy[k];
  return sum;
}

}  // namespace

namespace ARAP_ISA_NAMESPACE {

CellKernels cell_kernels();  // declared again in kernels.cpp
CellKernels cell_kernels() { return {fit_rotations, find_residual}; }

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap
