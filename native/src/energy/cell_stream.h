// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "base/aligned_buffer.h"
#include "energy/cell_energy.h"
#include "kernels/cell_kernels.h"

namespace arap {

/// The owner of a SlicedView.
template <class Real>
class SlicedRows {
 public:
  SlicedRows() = default;

  /// Zeros.
  /// @param sizes         entries of each row
  /// @param n_components  values of each entry
  SlicedRows(const std::vector<int>& sizes, int n_components, int threads);

  [[nodiscard]] int n_slices() const { return static_cast<int>(slice_offsets_.size()) - 1; }
  [[nodiscard]] int n_groups() const { return slice_offsets_.back(); }
  [[nodiscard]] SlicedView<Real> view() const { return {slice_offsets_.data(), indices_.data(), values_.data()}; }

  /// Sets entry e of a row.
  template <class... Values>
  void set(int row, int e, int index, Values... values) {
    const auto group = static_cast<size_t>(slice_offsets_[row / kSliceWidth]) + static_cast<size_t>(e);
    indices_[group * kSliceWidth + row % kSliceWidth] = index;
    size_t component = group * sizeof...(Values);
    ((values_[component++ * kSliceWidth + row % kSliceWidth] = static_cast<Real>(values)), ...);
  }

 private:
  std::vector<int> slice_offsets_{0};
  AlignedBuffer<int> indices_;
  AlignedBuffer<Real> values_;
};

/// A CellEnergy in the order in which an iteration reads it.
template <class Real>
struct CellStream {
  SlicedRows<Real> cells;          ///< row: cell, index: vertex, values: q_cj; all but the cell's first vertex
  AlignedBuffer<int> references;   ///< the first vertex of each cell, filled up to whole slices
  SlicedRows<Real> incidences;     ///< row: vertex, index: cell, values: q_cj
  SlicedRows<Real> off_diagonals;  ///< row: vertex j, index: vertex k other than j, value: -K_jk

  explicit CellStream(const CellEnergy& energy, int threads);
};

}  // namespace arap
