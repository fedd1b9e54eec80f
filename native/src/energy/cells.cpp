// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cells.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "base/permutation.h"

namespace arap {

namespace {

using Rows = Cells::Rows;

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

  /// Which entry of its cell the first one of each share is. Entry -1 is the home, or if the cell has
  /// none, its first vertex.
  [[nodiscard]] std::vector<std::vector<int>> first_entries() && {
    for (size_t c = 0; c < has_home.size(); ++c) {
      int entry = has_home[c] - 1;
      for (std::vector<int>& sizes : of_shares) entry += std::exchange(sizes[c], entry);
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

/// Entries of each row by vertex.
std::vector<int> row_sizes(const Rows& rows, const std::vector<int>& new_of_old) {
  const std::vector<int>& offsets = rows.offsets();
  std::vector<int> sizes(offsets.size() - 1);
  for (size_t v = 0; v < sizes.size(); ++v) sizes[new_of_old.empty() ? v : new_of_old[v]] = offsets[v + 1] - offsets[v];
  return sizes;
}

/// Others than the home.
std::vector<int> other_sizes(const std::vector<int>& sizes, const std::vector<int>& order) {
  std::vector<int> others;
  others.reserve(order.size());
  for (const int c : order) others.push_back(sizes[c] - 1);
  return others;
}

std::vector<int> at_least_0(std::vector<int> sizes) {
  for (int& size : sizes) size = std::max(0, size);
  return sizes;
}

}  // namespace

Cells::Cells(Rows rows, const std::vector<int>& homes, const std::vector<int>& new_of_old, const MeterPart& meter)
    : n_cells_(row_sizes(rows, new_of_old)), n_incidences_(static_cast<size_t>(rows.offsets().back())) {
  CellSizes sizes(rows, homes, meter.part(0.3));
  const std::vector<int> whole = sizes.whole();
  const std::vector<int> order = order_cells(homes, whole, new_of_old);
  const std::vector<int> new_cell = inverse_permutation(order);
  n_others_ = other_sizes(whole, order);
  meter.tell();
  by_cell_ = SlicedVectors(at_least_0(n_others_), rows.n_shares());
  meter.tell();
  by_vertex_ = SlicedVectors(n_cells_, rows.n_shares());
  meter.tell();
  homes_ = AlignedBuffer<int>(whole_slices(size()));
  std::fill_n(homes_.data(), homes_.size(), 0);
  std::vector<std::vector<int>> next = std::move(sizes).first_entries();
  const MeterPart filling = meter.part(0.7);
  rows.drain([&](int share, int old_vertex, std::span<const Rows::Entry> entries) {
    const int vertex = new_of_old.empty() ? old_vertex : new_of_old[old_vertex];
    int k = 0;
    for (const auto& [old_cell, q] : entries) {
      const int cell = new_cell[old_cell];
      by_vertex_.set(vertex, k++, cell, q);
      if (const int e = homes[old_cell] == old_vertex ? -1 : next[share][old_cell]++; e < 0)
        homes_[cell] = vertex;
      else
        by_cell_.set(cell, e, vertex, q);
    }
    count_row(old_vertex, static_cast<int>(n_cells_.size()), filling);
  });
}

namespace {

/// Rows that are what they were, or new ones.
class ChangedRows {
 public:
  using Row = std::vector<std::pair<int, Vector3>>;

  ChangedRows(const SlicedVectors& before, const std::vector<int>& sizes_before)
      : before_(before), sizes_(sizes_before) {}

  /// Changes are in the order of rows; further rows come last.
  void change(int row, Row entries) {
    sizes_.resize(std::max(sizes_.size(), static_cast<size_t>(row) + 1), -1);
    sizes_[row] = static_cast<int>(entries.size());
    changed_.emplace_back(row, std::move(entries));
  }

  [[nodiscard]] SlicedVectors rows(int threads, const MeterPart& meter) const {
    std::vector<char> is_own(slices_of(static_cast<int>(sizes_.size())), 0);
    for (const auto& [row, entries] : changed_) is_own[row / kSliceWidth] = 1;
    SlicedVectors result(before_, is_own, at_least_0(sizes_), threads);
    auto next = changed_.begin();
    for (int row = 0; row < std::ssize(sizes_); ++row) {
      count_row(row, static_cast<int>(sizes_.size()), meter);
      if (is_own[row / kSliceWidth] == 0) continue;
      if (next != changed_.end() && next->first == row) {
        for (int e = 0; e < sizes_[row]; ++e)
          result.set(row, e, next->second[e].first, SplitVector(next->second[e].second));
        ++next;
      } else {
        for (int e = 0; e < sizes_[row]; ++e)
          result.set(row, e, before_.index(row, e), SplitVector(before_.vector(row, e)));
      }
    }
    return result;
  }

 private:
  const SlicedVectors& before_;
  std::vector<int> sizes_;
  std::vector<std::pair<int, Row>> changed_;
};

}  // namespace

Cells::Cells(const Cells& others, CellChanges changes, int threads, const MeterPart& meter)
    : n_others_(others.n_others_), n_cells_(others.n_cells_), n_incidences_(others.n_incidences_) {
  if (!changes.cells.empty())
    n_others_.resize(std::max(n_others_.size(), static_cast<size_t>(changes.cells.back().number) + 1), -1);
  std::vector<int> change_of_cell(n_others_.size(), -1);
  for (int k = 0; k < std::ssize(changes.cells); ++k) change_of_cell[changes.cells[k].number] = k;
  std::vector<ChangedRows::Row> members(changes.cells.size());
  ChangedRows by_vertex(others.by_vertex_, others.n_cells_);
  for (auto& [v, row] : changes.vertices) {
    count_row(v, static_cast<int>(n_cells_.size()), meter.part(0.4));
    n_incidences_ += row.size() - static_cast<size_t>(n_cells_[v]);
    n_cells_[v] = static_cast<int>(row.size());
    for (const auto& [cell, q] : row)
      if (change_of_cell[cell] >= 0) members[change_of_cell[cell]].emplace_back(v, q);
    by_vertex.change(v, std::move(row));
  }
  homes_ = AlignedBuffer<int>(whole_slices(size()));
  std::fill_n(homes_.data(), homes_.size(), 0);
  std::copy_n(others.homes_.data(), others.homes_.size(), homes_.data());
  ChangedRows by_cell(others.by_cell_, others.n_others_);
  for (size_t k = 0; k < members.size(); ++k) {
    const CellChanges::Cell& change = changes.cells[k];
    ChangedRows::Row& row = members[k];
    const auto found =
        std::find_if(row.begin(), row.end(), [&](const auto& entry) { return entry.first == change.home; });
    const auto at = found != row.end() ? found : row.begin();
    n_others_[change.number] = static_cast<int>(row.size()) - 1;
    homes_[change.number] = row.empty() ? 0 : at->first;
    if (!row.empty()) row.erase(at);
    by_cell.change(change.number, std::move(row));
  }
  by_cell_ = by_cell.rows(threads, meter.part(0.3));
  by_vertex_ = by_vertex.rows(threads, meter.part(0.3));
}

}  // namespace arap
