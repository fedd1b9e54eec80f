// SPDX-License-Identifier: GPL-3.0-or-later
#include "cell_stream.h"

#include <algorithm>

namespace arap {

SlicedRows::SlicedRows(const std::vector<int>& offsets, int n_components) {
  const int n_rows = static_cast<int>(offsets.size()) - 1;
  for (int first = 0; first < n_rows; first += kSliceWidth) {
    int longest = 0;
    for (int row = first; row < std::min(n_rows, first + kSliceWidth); ++row)
      longest = std::max(longest, offsets[row + 1] - offsets[row]);
    slice_offsets_.push_back(slice_offsets_.back() + longest);
  }
  const size_t n_entries = static_cast<size_t>(slice_offsets_.back()) * kSliceWidth;
  indices_ = AlignedBuffer<int>(n_entries);
  values_ = AlignedBuffer<double>(n_entries * n_components);
  std::fill_n(indices_.data(), indices_.size(), 0);
  std::fill_n(values_.data(), values_.size(), 0.0);
}

CellStream::CellStream(const CellEnergy& energy) : cells(energy.cell_offsets, 3), incidences(energy.vertex_offsets, 3) {
  for (int c = 0; c < energy.n_cells(); ++c)
    for (int k = energy.cell_offsets[c]; k < energy.cell_offsets[c + 1]; ++k)
      cells.set(c, k - energy.cell_offsets[c], energy.cell_vertices[k], energy.q(k, 0), energy.q(k, 1), energy.q(k, 2));
  for (int v = 0; v < energy.n_vertices(); ++v)
    for (int k = energy.vertex_offsets[v]; k < energy.vertex_offsets[v + 1]; ++k) {
      const auto q = energy.q.row(energy.vertex_incidences[k]);
      incidences.set(v, k - energy.vertex_offsets[v], energy.vertex_cells[k], q[0], q[1], q[2]);
    }
  std::vector<int> column_offsets(energy.K.outerIndexPtr(), energy.K.outerIndexPtr() + energy.n_vertices() + 1);
  system = SlicedRows(column_offsets, 1);
  for (int v = 0; v < energy.n_vertices(); ++v)
    for (int k = column_offsets[v]; k < column_offsets[v + 1]; ++k)
      system.set(v, k - column_offsets[v], energy.K.innerIndexPtr()[k], energy.K.valuePtr()[k]);
}

}  // namespace arap
