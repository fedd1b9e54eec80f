// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cell_stream.h"

#include <algorithm>

#include "parallel/parallel.h"

namespace arap {

namespace {

/// Rows that a thread fills at once: whole slices, so that no two threads write to one. Cells may be few and large.
constexpr int kRowRange = 64 * kSliceWidth;
constexpr int kCellRange = 4 * kSliceWidth;

/// Groups that a thread zeroes at once: some megabytes.
constexpr int kZeroedGroups = 1 << 14;

std::vector<int> cell_sizes(const CellEnergy& energy) {
  std::vector<int> sizes(energy.n_cells());
  for (int c = 0; c < energy.n_cells(); ++c)
    sizes[c] = std::max(0, energy.cell_offsets[c + 1] - energy.cell_offsets[c] - 1);
  return sizes;
}

std::vector<int> incidence_counts(const CellEnergy& energy) {
  std::vector<int> sizes(energy.n_vertices());
  for (int v = 0; v < energy.n_vertices(); ++v) sizes[v] = energy.vertex_offsets[v + 1] - energy.vertex_offsets[v];
  return sizes;
}

std::vector<int> neighbor_counts(const SparseMatrix& K, int threads) {
  std::vector<int> sizes(K.cols());
  parallel_for<kRowRange>(threads, static_cast<int>(K.cols()), [&](int begin, int end) {
    for (int v = begin; v < end; ++v)
      for (SparseMatrix::InnerIterator it(K, v); it; ++it)
        if (it.row() != v) ++sizes[v];
  });
  return sizes;
}

}  // namespace

template <class Real>
SlicedRows<Real>::SlicedRows(const std::vector<int>& sizes, int n_components, int threads) {
  for (size_t first = 0; first < sizes.size(); first += kSliceWidth) {
    const auto begin = sizes.begin() + static_cast<std::ptrdiff_t>(first);
    const auto n = static_cast<std::ptrdiff_t>(std::min(size_t{kSliceWidth}, sizes.size() - first));
    slice_offsets_.push_back(slice_offsets_.back() + *std::max_element(begin, begin + n));
  }
  const size_t n_entries = static_cast<size_t>(slice_offsets_.back()) * kSliceWidth;
  indices_ = AlignedBuffer<int>(n_entries);
  values_ = AlignedBuffer<Real>(n_entries * n_components);
  // By all threads: memory that nothing has touched yet is the longest part of making it.
  parallel_for<kZeroedGroups>(threads, n_groups(), [&](int begin, int end) {
    const size_t first = static_cast<size_t>(begin) * kSliceWidth;
    const size_t n = static_cast<size_t>(end - begin) * kSliceWidth;
    std::fill_n(indices_.data() + first, n, 0);
    std::fill_n(values_.data() + first * n_components, n * n_components, Real{0});
  });
}

template <class Real>
CellStream<Real>::CellStream(const CellEnergy& energy, int threads)
    : cells(cell_sizes(energy), 3, threads),
      references(static_cast<size_t>(cells.n_slices()) * kSliceWidth),
      incidences(incidence_counts(energy), 3, threads),
      off_diagonals(neighbor_counts(energy.K, threads), 1, threads) {
  std::fill_n(references.data(), references.size(), 0);
  parallel_for<kCellRange>(threads, energy.n_cells(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      const int first = energy.cell_offsets[c];
      if (first < energy.cell_offsets[c + 1]) references[c] = energy.cell_vertices[first];
      for (int k = first + 1; k < energy.cell_offsets[c + 1]; ++k)
        cells.set(c, k - first - 1, energy.cell_vertices[k], energy.q(k, 0), energy.q(k, 1), energy.q(k, 2));
    }
  });
  parallel_for<kRowRange>(threads, energy.n_vertices(), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int k = energy.vertex_offsets[v]; k < energy.vertex_offsets[v + 1]; ++k) {
        const auto q = energy.q.row(energy.vertex_incidences[k]);
        incidences.set(v, k - energy.vertex_offsets[v], energy.vertex_cells[k], q[0], q[1], q[2]);
      }
      int e = 0;
      for (SparseMatrix::InnerIterator it(energy.K, v); it; ++it)
        if (it.row() != v) off_diagonals.set(v, e++, static_cast<int>(it.row()), -it.value());
    }
  });
}

template class SlicedRows<float>;
template class SlicedRows<double>;
template struct CellStream<float>;
template struct CellStream<double>;

}  // namespace arap
