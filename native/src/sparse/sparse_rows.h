// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "base/offsets.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "sparse/row_accumulator.h"

namespace arap {

/// Sparse rows that are computed in parallel, in shares of consecutive rows.
/// @tparam Stored  how values are kept
template <class Value, class Stored = Value>
class SparseRows {
 public:
  using Entry = std::pair<int, Stored>;

  /// @param make_fill  make_fill() is called once for each share and returns a function fill(row, RowAccumulator&),
  ///     which is called for each row of the share; entries keep the order of the accumulator
  template <class MakeFill>
  SparseRows(int n_rows, int n_columns, int threads, const MakeFill& make_fill, const MeterPart& meter = {})
      : shares_(threads, n_rows), pieces_(shares_.count()), offsets_(n_rows + 1, 0) {
    shares_.for_each([&](int share, int begin, int end) {
      auto fill = make_fill();
      RowAccumulator<Value> row(n_columns);
      for (int r = begin; r < end; ++r) {
        fill(r, row);
        offsets_[r + 1] = static_cast<int>(row.entries().size());
        append(row.entries(), pieces_[share]);
        row.clear();
        if (r % kReported == 0) meter.add(static_cast<double>(std::min(kReported, end - r)) / n_rows);
      }
    });
    make_offsets(offsets_);
  }

  [[nodiscard]] int n_shares() const { return shares_.count(); }
  /// (n_rows + 1,) first entry of each row.
  [[nodiscard]] const std::vector<int>& offsets() const { return offsets_; }

  /// Calls visit(share, row, entries) for the rows of each share in order, for several shares in parallel.
  template <class Visit>
  void for_each(const Visit& visit) const {
    visit_each(visit, [](int, size_t) {});
  }

  /// The same, and gives the memory back meanwhile. There are no entries any more then.
  template <class Visit>
  void drain(const Visit& visit) {
    visit_each(visit, [&](int share, size_t block) { std::vector<Entry>().swap(pieces_[share][block]); });
  }

 private:
  /// Blocks instead of one array: a share grows without moving its entries. The largest ones are such that an allocator
  /// gives them back to the system.
  using Piece = std::vector<std::vector<Entry>>;
  static constexpr size_t kFirstBlock = 1U << 15U;
  static constexpr size_t kLargestBlock = (size_t{33} << 20U) / sizeof(Entry);
  static constexpr int kReported = 4096;

  static void append(const std::vector<typename RowAccumulator<Value>::Entry>& row, Piece& piece) {
    if (piece.empty() || piece.back().size() + row.size() > piece.back().capacity()) {
      const size_t size = piece.empty() ? kFirstBlock : std::min(2 * piece.back().capacity(), kLargestBlock);
      piece.emplace_back().reserve(std::max(size, row.size()));
    }
    for (const auto& [column, value] : row) piece.back().emplace_back(column, Stored(value));
  }

  /// leave(share, block) when all rows of a block have been visited.
  template <class Visit, class Leave>
  void visit_each(const Visit& visit, const Leave& leave) const {
    shares_.for_each([&](int share, int begin, int end) {
      const Piece& piece = pieces_[share];
      size_t block = 0;
      size_t next = 0;
      for (int r = begin; r < end; ++r) {
        const auto size = static_cast<size_t>(offsets_[r + 1] - offsets_[r]);
        if (size == 0) continue;
        if (next == piece[block].size()) {
          leave(share, block++);
          next = 0;
        }
        visit(share, r, std::span<const Entry>(piece[block]).subspan(next, size));
        next += size;
      }
      if (block < piece.size()) leave(share, block);
    });
  }

  Shares shares_;
  std::vector<Piece> pieces_;
  std::vector<int> offsets_;
};

}  // namespace arap
