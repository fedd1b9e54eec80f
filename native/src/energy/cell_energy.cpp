// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cell_energy.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "base/permutation.h"
#include "sparse/sparse_rows.h"

namespace arap {

namespace {

using Rows = SparseRows<Vector3>;

/// Says at every so many rows that these are done.
void count_row(int row, int n_rows, const MeterPart& meter) {
  constexpr int kReported = 4096;
  if (row % kReported == 0) meter.add(static_cast<double>(kReported) / std::max(kReported, n_rows));
}

/// What each cell consists of.
struct CellSizes {
  std::vector<char> has_home;               ///< (n_cells,)
  std::vector<std::vector<int>> of_shares;  ///< (n_shares, n_cells) other vertices in each share of the rows

  CellSizes(const Rows& rows, const std::vector<int>& homes, const MeterPart& meter)
      : has_home(homes.size(), 0), of_shares(rows.n_shares(), std::vector<int>(homes.size(), 0)) {
    rows.for_each([&](int share, int vertex, std::span<const Rows::Entry> entries) {
      for (const auto& [cell, q] : entries)
        if (homes[cell] == vertex)
          has_home[cell] = 1;
        else
          ++of_shares[share][cell];
      count_row(vertex, static_cast<int>(rows.offsets().size()) - 1, meter);
    });
  }

  [[nodiscard]] std::vector<int> whole() const {
    std::vector<int> sum(has_home.begin(), has_home.end());
    for (const std::vector<int>& sizes : of_shares)
      std::transform(sum.begin(), sum.end(), sizes.begin(), sum.begin(), std::plus<>());
    return sum;
  }

  /// Where the first entry of each cell in each share goes: the home is the first of a cell, then come the shares.
  [[nodiscard]] std::vector<std::vector<int>> first_places(const std::vector<int>& cell_offsets,
                                                           const std::vector<int>& new_cell) && {
    for (size_t c = 0; c < new_cell.size(); ++c) {
      int place = cell_offsets[new_cell[c]] + has_home[c];
      for (std::vector<int>& sizes : of_shares) place += std::exchange(sizes[c], place);
    }
    return std::move(of_shares);
  }
};

/// Cells as their homes will be numbered. Last come those that are far larger than most, the largest first, and then
/// empty ones: a row of a slice is filled up to the longest, and such a cell among others would make fifteen as long.
std::vector<int> order_cells(const std::vector<int>& homes, const std::vector<int>& sizes,
                             const std::vector<int>& new_of_old) {
  std::vector<int> order(homes.size());
  std::iota(order.begin(), order.end(), 0);
  if (new_of_old.empty()) return order;
  constexpr size_t kFarLarger = 32;
  const size_t mean = std::reduce(sizes.begin(), sizes.end(), size_t{0}) / std::max<size_t>(1, order.size());
  const auto place = [&](int c) {
    const bool is_last = sizes[c] == 0 || static_cast<size_t>(sizes[c]) > kFarLarger * (mean + 1);
    return is_last ? std::numeric_limits<int>::max() - sizes[c] : new_of_old[homes[c]];
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return place(a) < place(b); });
  // Neighbouring rows of a slice are filled up to the longest. Cells of vertices are about the same size and near each
  // other in memory; of large cells each is far from the next in any order.
  constexpr size_t kLarge = 64;
  constexpr std::ptrdiff_t kWindow = 256;
  if (mean < kLarge) return order;
  for (auto begin = order.begin(); begin < order.end(); begin += std::min(kWindow, order.end() - begin))
    std::stable_sort(begin, begin + std::min(kWindow, order.end() - begin),
                     [&](int a, int b) { return sizes[a] > sizes[b]; });
  return order;
}

/// Where each begins among all, and the end.
std::vector<int> offsets_of(const std::vector<int>& sizes, const std::vector<int>& order) {
  std::vector<int> offsets{0};
  offsets.reserve(order.size() + 1);
  for (const int i : order) offsets.push_back(offsets.back() + sizes[i]);
  return offsets;
}

/// The same for vertices, whose sizes are those of the rows.
std::vector<int> vertex_offsets_of(const Rows& rows, const std::vector<int>& new_of_old) {
  const std::vector<int>& old = rows.offsets();
  if (new_of_old.empty()) return old;
  std::vector<int> offsets(old.size(), 0);
  for (size_t v = 0; v < new_of_old.size(); ++v) offsets[new_of_old[v] + 1] = old[v + 1] - old[v];
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
  return offsets;
}

}  // namespace

void CellEnergy::set_cells(SparseRows<Vector3> rows, const std::vector<int>& homes, const std::vector<int>& new_of_old,
                           const MeterPart& meter) {
  CellSizes sizes(rows, homes, meter.part(0.3));
  const std::vector<int> whole = sizes.whole();
  const std::vector<int> cell_order = order_cells(homes, whole, new_of_old);
  const std::vector<int> new_cell = inverse_permutation(cell_order);
  cell_offsets = offsets_of(whole, cell_order);
  vertex_offsets = vertex_offsets_of(rows, new_of_old);
  std::vector<std::vector<int>> next = std::move(sizes).first_places(cell_offsets, new_cell);
  cell_vertices.resize(cell_offsets.back());
  q.resize(cell_offsets.back(), 3);
  vertex_incidences.resize(cell_vertices.size());
  vertex_cells.resize(cell_vertices.size());
  const MeterPart filling = meter.part(0.7);
  rows.drain([&](int share, int old_vertex, std::span<const Rows::Entry> entries) {
    const int vertex = new_of_old.empty() ? old_vertex : new_of_old[old_vertex];
    int k = vertex_offsets[vertex];
    for (const auto& [cell, value] : entries) {
      const int slot = homes[cell] == old_vertex ? cell_offsets[new_cell[cell]] : next[share][cell]++;
      cell_vertices[slot] = vertex;
      q.row(slot) = value.transpose();
      vertex_incidences[k] = slot;
      vertex_cells[k++] = new_cell[cell];
    }
    count_row(old_vertex, static_cast<int>(vertex_offsets.size()) - 1, filling);
  });
}

}  // namespace arap
