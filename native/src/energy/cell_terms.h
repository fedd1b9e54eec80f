// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/aligned_buffer.h"
#include "energy/cell_energy.h"
#include "kernels/kernels.h"
#include "parallel/parallel.h"

namespace arap {

/// Slices that a thread takes at once.
inline constexpr int kSliceRange = 32;

// What CellPasses asks of the cells of an energy, range by range of slices. find_covariances() comes before the fits of
// new positions, find_turns() before the residual of new rotations.

template <class Real>
[[nodiscard]] const CellKernels<Real>& cell_kernels(Isa isa) {
  if constexpr (std::is_same_v<Real, float>)
    return kernels(isa).single_cell;
  else
    return kernels(isa).double_cell;
}

template <class Real>
[[nodiscard]] const CubeKernels<Real>& cube_kernels(Isa isa) {
  if constexpr (std::is_same_v<Real, float>)
    return kernels(isa).single_cube;
  else
    return kernels(isa).double_cube;
}

/// Of listed cells: nothing is found before.
template <class Real>
class ListedTerms {
 public:
  ListedTerms(const CellEnergy& /*energy*/, const Cells& cells, const Workers& /*workers*/, Isa isa)
      : kernels_(cell_kernels<Real>(isa)),
        cells_(cells),
        range_(slice_range(cells_.by_cell().n_slices(), cells_.by_cell().n_groups())) {}

  [[nodiscard]] int n_cell_slices() const { return cells_.by_cell().n_slices(); }
  [[nodiscard]] int n_vertex_slices() const { return cells_.by_vertex().n_slices(); }
  /// Slices of cells that a thread takes at once.
  [[nodiscard]] int cell_range() const { return range_; }

  void find_covariances(const PositionsView<Real>& /*positions*/) {}
  double fit_rotations(const PositionsView<Real>& positions, const VolumeView<Real>& volumes, Real* rotations,
                       int begin, int end) const {
    double sum = 0;
    cells_.by_cell().for_each_view(begin, end, [&](const SplitView& view, int from, int to) {
      sum += kernels_.fit_rotations(view, cells_.homes(), positions, volumes, rotations, from, to);
    });
    return sum;
  }
  [[nodiscard]] double alignment(const PositionsView<Real>& positions, const VolumeView<Real>& volumes,
                                 const Real* rotations, int begin, int end) const {
    double sum = 0;
    cells_.by_cell().for_each_view(begin, end, [&](const SplitView& view, int from, int to) {
      sum += kernels_.alignment(view, cells_.homes(), positions, volumes, rotations, from, to);
    });
    return sum;
  }
  void find_turns(const Real* /*rotations*/, const Real* /*stresses*/) const {}
  double residual(const SlicedView<Real>& off_diagonals, const PositionsView<Real>& positions, const Real* rotations,
                  const Real* stresses, double* residual, int n_vertices, int begin, int end) const {
    double sum = 0;
    cells_.by_vertex().for_each_view(begin, end, [&](const SplitView& view, int from, int to) {
      sum += kernels_.residual(view, off_diagonals, positions, rotations, stresses, residual, n_vertices, from, to);
    });
    return sum;
  }

  /// (n_cells,) tr(Q_c) / 3 at rest.
  [[nodiscard]] std::vector<double> traces(const Positions& rest, const Workers& workers) const {
    std::vector<double> result(cells_.size(), 0);
    parallel_for(workers, cells_.size(), [&](int begin, int end) {
      for (int c = begin; c < end; ++c)
        cells_.for_each_vertex(
            c, [&](int v, const Vector3& q) { result[c] += (rest.row(v) - rest.row(cells_.home(c))).dot(q) / 3; });
    });
    return result;
  }

 private:
  /// Fewer of slices with many groups: about as much work.
  static int slice_range(int n_slices, int n_groups) {
    constexpr std::int64_t kGroups = std::int64_t{8} * kSliceRange;
    if (n_groups == 0) return kSliceRange;
    return static_cast<int>(std::clamp<std::int64_t>(kGroups * n_slices / n_groups, 1, kSliceRange));
  }

  const CellKernels<Real>& kernels_;
  const Cells& cells_;
  int range_;
};

/// Of cells made of cubes.
template <class Real>
class CubeTerms {
 public:
  CubeTerms(const CellEnergy& energy, const Cells& /*cells*/, Workers workers, Isa isa)
      : kernels_(cube_kernels<Real>(isa)),
        cubes_(energy.cubes),
        workers_(std::move(workers)),
        weights_(cubes_.weights().begin(), cubes_.weights().end()),
        gradients_(kNumbers * static_cast<size_t>(cubes_.n_cubes())),
        means_(kNumbers * static_cast<size_t>(cubes_.n_cubes())),
        turns_(kNumbers * whole_slices(cubes_.size())) {}

  [[nodiscard]] int n_cell_slices() const { return slices_of(cubes_.size()); }
  [[nodiscard]] int n_vertex_slices() const { return n_cell_slices(); }
  [[nodiscard]] int cell_range() const { return kSliceRange; }

  void find_covariances(const PositionsView<Real>& positions) {
    parallel_for<kCubeRange>(workers_, cubes_.n_cubes(), [&](int begin, int end) {
      kernels_.gradients(view(), positions, gradients_.data(), begin, end);
    });
  }
  double fit_rotations(const PositionsView<Real>& /*positions*/, const VolumeView<Real>& volumes, Real* rotations,
                       int begin, int end) const {
    return kernels_.fit_rotations(view(), gradients_.data(), volumes, rotations, begin, end);
  }
  [[nodiscard]] double alignment(const PositionsView<Real>& /*positions*/, const VolumeView<Real>& volumes,
                                 const Real* rotations, int begin, int end) const {
    return kernels_.alignment(view(), gradients_.data(), volumes, rotations, begin, end);
  }
  void find_turns(const Real* rotations, const Real* stresses) {
    parallel_for<kSliceRange>(workers_, n_cell_slices(), [&](int begin, int end) {
      kernels_.turns(rotations, stresses, turns_.data(), begin, end);
    });
    parallel_for<kCubeRange>(workers_, cubes_.n_cubes(), [&](int begin, int end) {
      kernels_.mean_turns(view(), turns_.data(), means_.data(), begin, end);
    });
  }
  double residual(const SlicedView<Real>& off_diagonals, const PositionsView<Real>& positions,
                  const Real* /*rotations*/, const Real* /*stresses*/, double* residual, int n_vertices, int begin,
                  int end) const {
    return kernels_.residual(view(), means_.data(), off_diagonals, positions, residual, n_vertices, begin, end);
  }

  [[nodiscard]] std::vector<double> traces(const Positions& rest, const Workers& /*workers*/) const {
    const CubeCells::ControlPoints& of_cube = cubes_.control_points(0);
    return cubes_.traces((rest(of_cube.back(), 0) - rest(of_cube.front(), 0)) / 2);
  }

 private:
  static constexpr size_t kNumbers = 12;  // of a matrix of three columns
  static constexpr int kCubeRange = 256;  // that a thread takes at once

  [[nodiscard]] CubeView<Real> view() const {
    return {cubes_.control_points(0).data(), weights_.data(), cubes_.offsets().data(), cubes_.slots().data()};
  }

  const CubeKernels<Real>& kernels_;
  const CubeCells& cubes_;
  Workers workers_;
  std::vector<Real> weights_;
  AlignedBuffer<Real> gradients_;  ///< (n_cubes, 3, 4)
  AlignedBuffer<Real> means_;      ///< (n_cubes, 3, 4)
  AlignedBuffer<Real> turns_;      ///< (n_cells, 3, 4)
};

}  // namespace arap
