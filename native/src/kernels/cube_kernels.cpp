// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.

#include "kernels/cell_kernels.h"
#include "kernels/cell_lanes.h"

namespace arap {

namespace {

/// A column of a 3 x 3 matrix; the fourth number has no meaning.
template <class Real>
using Column = Vector<Real, 4>;

constexpr int kNumbers = 12;  // of three columns

template <class Real>
struct Columns {
  Column<Real> v[3];  // NOLINT: no std::array here, see simd.h
  [[gnu::always_inline]] Column<Real>& operator[](int i) { return v[i]; }
};

template <class Real>
[[gnu::always_inline]] inline const Real* columns_of(const Real* matrices, std::ptrdiff_t i) {
  return matrices + kNumbers * i;
}

template <class Real>
[[gnu::always_inline]] inline void add_scaled(Real factor, const Real* columns, Columns<Real>& sum) {
  for (int j = 0; j < 3; ++j) sum[j] += factor * load<Real, 4>(columns + 4 * j);
}

template <class Real>
[[gnu::always_inline]] inline void store_scaled(Real factor, const Columns<Real>& columns, Real* out) {
  for (int j = 0; j < 3; ++j) store<Real, 4>(out + std::ptrdiff_t{4} * j, factor * columns.v[j]);
}

/// Of the control points along an axis: the mean over a cube of its octants' linear weights.
constexpr double kMean[3] = {0.125, 0.75, 0.125};  // NOLINT
/// The shares of their rotations.
constexpr double kSmooth[3] = {1.0 / 6, 2.0 / 3, 1.0 / 6};  // NOLINT

/// What control point 9 x + 3 y + z has of a cube.
template <class Real>
struct Shares {
  Real smooth[kControlPoints]{};        // NOLINT
  Real gradients[kControlPoints][3]{};  // NOLINT  means of those of its linear weights

  constexpr Shares() {
    for (int k = 0; k < kControlPoints; ++k) {
      const int x = k / 9;
      const int y = k / 3 % 3;
      const int z = k % 3;
      smooth[k] = static_cast<Real>(kSmooth[x] * kSmooth[y] * kSmooth[z]);
      gradients[k][0] = static_cast<Real>((x - 1) * kMean[y] * kMean[z] / 2);
      gradients[k][1] = static_cast<Real>((y - 1) * kMean[x] * kMean[z] / 2);
      gradients[k][2] = static_cast<Real>((z - 1) * kMean[x] * kMean[y] / 2);
    }
  }
};
template <class Real>
constexpr Shares<Real> kShares;

/// b - a, exact but for the final rounding to Real.
template <class Real>
[[gnu::always_inline]] inline Column<Real> from_to(const Coordinate<Real>* rows, int a, int b) {
  const auto row = [&](int i) __attribute__((always_inline)) {
    return load<Coordinate<Real>, 4>(rows + std::ptrdiff_t{4} * i);
  };
  if constexpr (sizeof(Real) == sizeof(double)) {
    return row(b) - row(a);
  } else {
    using Bits = Vector<unsigned, 4>;  // the fourth numbers may be anything
    const Bits difference = __builtin_bit_cast(Bits, row(b)) - __builtin_bit_cast(Bits, row(a));
    return __builtin_convertvector(__builtin_bit_cast(Vector<int, 4>, difference), Column<Real>);
  }
}

template <class Real>
void find_gradients(const CubeView<Real>& cubes, const PositionsView<Real>& positions, Real* gradients, int begin,
                    int end) {
  for (std::ptrdiff_t e = begin; e < end; ++e) {
    const int* c = cubes.control_points + kControlPoints * e;
    Columns<Real> sum{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const auto share = static_cast<Real>(kMean[i] * kMean[j] / 2);
        sum[0] += share * from_to<Real>(positions.rows, c[3 * i + j], c[3 * i + j + 18]);
        sum[1] += share * from_to<Real>(positions.rows, c[9 * i + j], c[9 * i + j + 6]);
        sum[2] += share * from_to<Real>(positions.rows, c[9 * i + 3 * j], c[9 * i + 3 * j + 2]);
      }
    store_scaled<Real>(cubes.weights[e] * positions.unit, sum, gradients + kNumbers * e);
  }
}

/// Q_c of the cells in a vector's lanes, `first` and those after it.
template <class Real>
[[gnu::always_inline]] inline Matrix<Real> covariances(const CubeView<Real>& cubes, const Real* gradients,
                                                       std::ptrdiff_t first) {
  Real of_cells[kLaneCount<Real> * kNumbers];  // NOLINT
  for (int k = 0; k < kLaneCount<Real>; ++k) {
    Columns<Real> sum{};
    for (int s = cubes.offsets[first + k]; s < cubes.offsets[first + k + 1]; ++s) {
      const auto slot = static_cast<unsigned>(cubes.slots[s]);
      add_scaled<Real>(kShares<Real>.smooth[slot % kCubeSlots], columns_of(gradients, slot / kCubeSlots), sum);
    }
    store_scaled<Real>(1, sum, of_cells + kNumbers * k);
  }
  Matrix<Real> Q{};
  for (int j = 0; j < 3; ++j) {
    const Four<Real> column = components<Real>([&](int k) __attribute__((always_inline)) {
      return load<Real, 4>(of_cells + kNumbers * k + std::ptrdiff_t{4} * j);
    });
    for (int i = 0; i < 3; ++i) Q[i][j] = column[i];
  }
  return Q;
}

/// use(first cell) for each vector of the cells in slices [begin, end).
template <class Real, class Use>
[[gnu::always_inline]] inline void for_each_vector(int begin, int end, const Use& use) {
  for (std::ptrdiff_t first = std::ptrdiff_t{kSliceWidth} * begin; first < std::ptrdiff_t{kSliceWidth} * end;
       first += kLaneCount<Real>)
    use(first);
}

template <class Real>
double fit_cube_rotations(const CubeView<Real>& cubes, const Real* gradients, const VolumeView<Real>& volumes,
                          Real* rotations, int begin, int end) {
  LaneSum<Real> sum;
  for_each_vector<Real>(
      begin, end, [&](std::ptrdiff_t first) __attribute__((always_inline)) {
        fit_cells<Real>(covariances<Real>(cubes, gradients, first), volumes, rotations, first, sum);
      });
  return sum.total();
}

template <class Real>
double find_cube_alignment(const CubeView<Real>& cubes, const Real* gradients, const VolumeView<Real>& volumes,
                           const Real* rotations, int begin, int end) {
  LaneSum<Real> sum;
  for_each_vector<Real>(
      begin, end, [&](std::ptrdiff_t first) __attribute__((always_inline)) {
        align_cells<Real>(covariances<Real>(cubes, gradients, first), volumes, rotations, first, sum);
      });
  return sum.total();
}

template <class Real>
void find_turns(const Real* rotations, const Real* stresses, Real* turns, int begin, int end) {
  for_each_vector<Real>(
      begin, end, [&](std::ptrdiff_t first) __attribute__((always_inline)) {
        Matrix<Real> turn = to_matrix<Real>(load_rotations<Real>(rotations + 4 * first));
        for (int i = 0; i < 3 && stresses != nullptr; ++i) {
          const Four<Real> row = components<Real>([&](int k) __attribute__((always_inline)) {
            return load<Real, 4>(stresses + kNumbers * (first + k) + std::ptrdiff_t{4} * i);
          });
          for (int j = 0; j < 3; ++j) turn[i][j] += row[j];
        }
        for (int j = 0; j < 3; ++j)
          for_each_row<Real>(
              {{turn[0][j], turn[1][j], turn[2][j], Lanes<Real>{}}}, [&](int k, const Column<Real>& column)
                                                                         __attribute__((always_inline)) {
                                                                           store<Real, 4>(turns +
                                                                                              kNumbers * (first + k) +
                                                                                              std::ptrdiff_t{4} * j,
                                                                                          column);
                                                                         });
      });
}

template <class Real>
void find_mean_turns(const CubeView<Real>& cubes, const Real* turns, Real* means, int begin, int end) {
  for (std::ptrdiff_t e = begin; e < end; ++e) {
    const int* c = cubes.control_points + kControlPoints * e;
    Columns<Real> sum{};
    for (int k = 0; k < kControlPoints; ++k) add_scaled<Real>(kShares<Real>.smooth[k], columns_of(turns, c[k]), sum);
    store_scaled<Real>(cubes.weights[e], sum, means + kNumbers * e);
  }
}

/// b of the control points in a vector's lanes.
template <class Real>
[[gnu::always_inline]] inline Three<Real> forces_of(const CubeView<Real>& cubes, const Real* means, int first) {
  const Four<Real> forces = components<Real>([&](int k) __attribute__((always_inline)) {
    Column<Real> sum{};
    for (int s = cubes.offsets[first + k]; s < cubes.offsets[first + k + 1]; ++s) {
      const auto slot = static_cast<unsigned>(cubes.slots[s]);
      const Real* mean = columns_of(means, slot / kCubeSlots);
      for (int j = 0; j < 3; ++j)
        sum += kShares<Real>.gradients[slot % kCubeSlots][j] * load<Real, 4>(mean + std::ptrdiff_t{4} * j);
    }
    return sum;
  });
  return {{forces[0], forces[1], forces[2]}};
}

template <class Real>
double find_cube_residual(const CubeView<Real>& cubes, const Real* means, const SlicedView<Real>& off_diagonals,
                          const PositionsView<Real>& positions, double* residual, int n_vertices, int begin, int end) {
  LaneSum<Real> energy;
  for (int slice = begin; slice < end; ++slice)
    for (int part = 0; part < kSliceWidth; part += kLaneCount<Real>) {
      const int first = slice * kSliceWidth + part;
      if (first >= n_vertices) break;
      Three<Real> sum = forces_of<Real>(cubes, means, first);
      add_stiffness<Real>(off_diagonals, positions, slice, part, sum, energy);
      store_rows<Real>(sum, n_vertices - first, residual + 3 * static_cast<std::ptrdiff_t>(first));
    }
  return 0.25 * energy.total();
}

template <class Real>
constexpr CubeKernels<Real> kCubeKernels{find_gradients<Real>, fit_cube_rotations<Real>, find_cube_alignment<Real>,
                                         find_turns<Real>,     find_mean_turns<Real>,    find_cube_residual<Real>};

}  // namespace

namespace ARAP_ISA_NAMESPACE {

CubeKernels<float> single_cube_kernels();  // declared again in kernels.cpp
CubeKernels<double> double_cube_kernels();
CubeKernels<float> single_cube_kernels() { return kCubeKernels<float>; }
CubeKernels<double> double_cube_kernels() { return kCubeKernels<double>; }

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap
