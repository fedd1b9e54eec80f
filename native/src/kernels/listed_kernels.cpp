// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.

#include "kernels/cell_kernels.h"

#include "kernels/cell_lanes.h"

namespace arap {

namespace {

/// Component j of the rest vectors in the lanes of a group from `part` on.
template <class Real>
[[gnu::always_inline]] inline Lanes<Real> rest_component(const SplitView& rows, int group, int j, int part) {
  constexpr int kCount = kLaneCount<Real>;
  const std::ptrdiff_t at = lanes_of(group, 3) + static_cast<std::ptrdiff_t>(j) * kSliceWidth + part;
  if constexpr (sizeof(Real) == sizeof(float)) {
    return load<float, kCount>(rows.high + at);
  } else {
    using Integers = Vector<int, kCount>;
    constexpr int kExponent = 0x7f800000;
    const Vector<float, kCount> high = load<float, kCount>(rows.high + at);
    const auto power = __builtin_bit_cast(Vector<float, kCount>, __builtin_bit_cast(Integers, high) & kExponent);
    const Integers low =
        __builtin_convertvector(load<short, kCount>(rows.low + at), Integers);  // NOLINT: see cell_kernels.h
    const auto rest = __builtin_convertvector(low, Lanes<double>) * __builtin_convertvector(power, Lanes<double>);
    return __builtin_convertvector(high, Lanes<double>) + broadcast<double>(0x1p-39) * rest;
  }
}

template <class Real>
double store_positions(const double* positions, int n, double range, Coordinate<Real>* rows) {
  using Row = Vector<double, 4>;
  Row largest{};
  Row zero{};  // NaN as soon as one of the numbers is not finite
  const auto store_row = [&](int v, const Row& x) __attribute__((always_inline)) {
    const Row size = x < 0 ? -x : x;
    largest = size > largest ? size : largest;
    zero += 0 * x;
    if constexpr (sizeof(Real) == sizeof(double))
      store<double, 4>(rows + std::ptrdiff_t{4} * v, x);
    else  // rounds down, which moves all positions alike
      store<int, 4>(rows + std::ptrdiff_t{4} * v,
                    __builtin_convertvector((x + range) * (kFixedPointUnits / range), Vector<int, 4>));
  };
  for (int v = 0; v + 1 < n; ++v) store_row(v, load<double, 4>(positions + std::ptrdiff_t{3} * v));
  if (n > 0) {
    const double* last = positions + std::ptrdiff_t{3} * (n - 1);
    store_row(n - 1, Row{last[0], last[1], last[2], 0});
  }
  double result = zero[0] + zero[1] + zero[2] + zero[3];
  for (int i = 0; i < 4; ++i) result = largest[i] > result ? largest[i] : result;
  return result;
}

/// The contribution of groups [begin, end) of a slice to Q_c, for the cells in the lanes from `part` on.
template <class Real>
[[gnu::always_inline]] inline Matrix<Real> partial_covariances(const SplitView& cells, const StoredRows<Real>& own,
                                                               const Coordinate<Real>* rows, int part, int begin,
                                                               int end) {
  Matrix<Real> Q{};
  for (int group = begin; group < end; ++group) {
    const int* index = cells.indices + lanes_of(group, 1) + part;
    const Three<Real> e = differences<Real>(stored_rows<Real>(
                                                rows, [&](int k) __attribute__((always_inline)) { return index[k]; }),
                                            own);
    for (int j = 0; j < 3; ++j) {
      const Lanes<Real> qj = rest_component<Real>(cells, group, j, part);
      for (int i = 0; i < 3; ++i) Q[i][j] += e[i] * qj;
    }
  }
  return Q;
}

/// Q_c of the cells of a slice, by the parts of it that a vector holds.
template <class Real>
struct SliceCovariances {
  static constexpr int kParts = kSliceWidth / kLaneCount<Real>;
  Matrix<Real> parts[kParts];  // NOLINT
};

/// Adds to a sum of many chunks with Kahan's compensation.
template <class Real>
[[gnu::always_inline]] inline void add_chunk(const Matrix<Real>& chunk, Matrix<Real>& Q, Matrix<Real>& lost) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Lanes<Real> more = chunk[i][j] - lost[i][j];
      const Lanes<Real> sum = Q[i][j] + more;
      lost[i][j] = (sum - Q[i][j]) - more;
      Q[i][j] = sum;
    }
}

/// Chunk by chunk: parts share cache lines.
template <class Real>
[[gnu::always_inline]] inline SliceCovariances<Real> covariances(const SplitView& cells, const int* homes,
                                                                 const PositionsView<Real>& positions, int slice) {
  constexpr int kParts = SliceCovariances<Real>::kParts;
  constexpr int kChunk = 64;
  SliceCovariances<Real> Q{};
  SliceCovariances<Real> lost{};
  StoredRows<Real> own[kParts];  // NOLINT
  for (int p = 0; p < kParts; ++p) {
    const int* home = homes + (static_cast<std::ptrdiff_t>(slice) * kSliceWidth + p * kLaneCount<Real>);
    own[p] = stored_rows<Real>(
        positions.rows, [&](int k) __attribute__((always_inline)) { return home[k]; });
  }
  const auto chunk = [&](int p, int begin) __attribute__((always_inline)) {
    const int end = cells.offsets[slice + 1];
    return partial_covariances<Real>(cells, own[p], positions.rows, p * kLaneCount<Real>, begin,
                                     end - begin > kChunk ? begin + kChunk : end);
  };
  int begin = cells.offsets[slice];
  for (int p = 0; p < kParts; ++p) Q.parts[p] = chunk(p, begin);
  for (begin += kChunk; begin < cells.offsets[slice + 1]; begin += kChunk)
    for (int p = 0; p < kParts; ++p) add_chunk<Real>(chunk(p, begin), Q.parts[p], lost.parts[p]);
  if constexpr (sizeof(Real) == sizeof(float))
    for (Matrix<Real>& part : Q.parts)
      for (int i = 0; i < 9; ++i) part[i / 3][i % 3] *= broadcast<Real>(positions.unit);
  return Q;
}

template <class Real>
double fit_rotations(const SplitView& cells, const int* homes, const PositionsView<Real>& positions,
                     const VolumeView<Real>& volumes, Real* rotations, int begin, int end) {
  LaneSum<Real> sum;
  for (int slice = begin; slice < end; ++slice) {
    const SliceCovariances<Real> by_part = covariances<Real>(cells, homes, positions, slice);
    std::ptrdiff_t first = std::ptrdiff_t{kSliceWidth} * slice;
    for (const Matrix<Real>& Q : by_part.parts) {
      fit_cells<Real>(Q, volumes, rotations, first, sum);
      first += kLaneCount<Real>;
    }
  }
  return sum.total();
}

template <class Real>
double find_alignment(const SplitView& cells, const int* homes, const PositionsView<Real>& positions,
                      const VolumeView<Real>& volumes, const Real* rotations, int begin, int end) {
  LaneSum<Real> sum;
  for (int slice = begin; slice < end; ++slice) {
    const SliceCovariances<Real> by_part = covariances<Real>(cells, homes, positions, slice);
    std::ptrdiff_t first = std::ptrdiff_t{kSliceWidth} * slice;
    for (const Matrix<Real>& Q : by_part.parts) {
      align_cells<Real>(Q, volumes, rotations, first, sum);
      first += kLaneCount<Real>;
    }
  }
  return sum.total();
}

/// R q with R as a unit quaternion (u, w):  q + w t + u x t with t = 2 u x q.
template <class Real>
[[gnu::always_inline]] inline void add_rotated(const Quaternion<Real>& R, const Three<Real>& q, Three<Real>& sum) {
  const Lanes<Real> cross0 = R[1] * q[2] - R[2] * q[1];
  const Lanes<Real> cross1 = R[2] * q[0] - R[0] * q[2];
  const Lanes<Real> cross2 = R[0] * q[1] - R[1] * q[0];
  const Lanes<Real> t0 = cross0 + cross0;
  const Lanes<Real> t1 = cross1 + cross1;
  const Lanes<Real> t2 = cross2 + cross2;
  sum[0] += q[0] + R[3] * t0 + R[1] * t2 - R[2] * t1;
  sum[1] += q[1] + R[3] * t1 + R[2] * t0 - R[0] * t2;
  sum[2] += q[2] + R[3] * t2 + R[0] * t1 - R[1] * t0;
}

/// Adds P q for the stresses P of the cells index[k].
template <class Real>
[[gnu::always_inline]] inline void add_stressed(const Real* stresses, const int* index, const Three<Real>& q,
                                                Three<Real>& sum) {
  for (int i = 0; i < 3; ++i) {
    const Four<Real> row = components<Real>([&](int k) __attribute__((always_inline)) {
      return load<Real, 4>(stresses + 12 * static_cast<std::ptrdiff_t>(index[k]) + std::ptrdiff_t{4} * i);
    });
    sum[i] += row[0] * q[0] + row[1] * q[1] + row[2] * q[2];
  }
}

template <class Real, bool has_stresses>
double find_residual_of(const SplitView& incidences, const SlicedView<Real>& off_diagonals,
                        const PositionsView<Real>& positions, const Real* rotations, const Real* stresses,
                        double* residual, int n_vertices, int begin, int end) {
  constexpr int kCount = kLaneCount<Real>;
  LaneSum<Real> energy;
  for (int slice = begin; slice < end; ++slice)
    for (int part = 0; part < kSliceWidth; part += kCount) {
      const int first = slice * kSliceWidth + part;
      if (first >= n_vertices) break;
      Three<Real> sum{};
      for (int group = incidences.offsets[slice]; group < incidences.offsets[slice + 1]; ++group) {
        const int* index = incidences.indices + lanes_of(group, 1) + part;
        const Quaternion<Real> R = components<Real>([&](int k) __attribute__((always_inline)) {
          return load<Real, 4>(rotations + 4 * static_cast<std::ptrdiff_t>(index[k]));
        });
        const Three<Real> q{{rest_component<Real>(incidences, group, 0, part),
                             rest_component<Real>(incidences, group, 1, part),
                             rest_component<Real>(incidences, group, 2, part)}};
        add_rotated<Real>(R, q, sum);
        if constexpr (has_stresses) add_stressed<Real>(stresses, index, q, sum);
      }
      add_stiffness<Real>(off_diagonals, positions, slice, part, sum, energy);
      store_rows<Real>(sum, n_vertices - first, residual + 3 * static_cast<std::ptrdiff_t>(first));
    }
  return 0.25 * energy.total();
}

template <class Real>
double find_residual(const SplitView& incidences, const SlicedView<Real>& off_diagonals,
                     const PositionsView<Real>& positions, const Real* rotations, const Real* stresses,
                     double* residual, int n_vertices, int begin, int end) {
  const auto find = stresses == nullptr ? find_residual_of<Real, false> : find_residual_of<Real, true>;
  return find(incidences, off_diagonals, positions, rotations, stresses, residual, n_vertices, begin, end);
}

}  // namespace

namespace ARAP_ISA_NAMESPACE {

CellKernels<float> single_cell_kernels();  // declared again in kernels.cpp
CellKernels<double> double_cell_kernels();
CellKernels<float> single_cell_kernels() {
  return {store_positions<float>, fit_rotations<float>, find_alignment<float>, find_residual<float>};
}
CellKernels<double> double_cell_kernels() {
  return {store_positions<double>, fit_rotations<double>, find_alignment<double>, find_residual<double>};
}

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap
