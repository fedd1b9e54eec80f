// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/aligned_buffer.h"
#include "energy/split_vector.h"
#include "kernels/cell_kernels.h"

namespace arap {

/// Slices of n rows.
[[nodiscard]] constexpr int slices_of(int n) { return (n + kSliceWidth - 1) / kSliceWidth; }
/// n, filled up to whole slices.
[[nodiscard]] constexpr size_t whole_slices(int n) { return size_t{kSliceWidth} * static_cast<size_t>(slices_of(n)); }

/// Where the entries of rows are: sixteen rows side by side, see SlicedView.
class SliceLayout {
 public:
  SliceLayout() = default;
  /// @param sizes  entries of each row
  explicit SliceLayout(const std::vector<int>& sizes);

  [[nodiscard]] int n_slices() const { return static_cast<int>(offsets_.size()) - 1; }
  [[nodiscard]] int n_groups() const { return offsets_.back(); }
  [[nodiscard]] size_t n_entries() const { return static_cast<size_t>(n_groups()) * kSliceWidth; }
  [[nodiscard]] const int* offsets() const { return offsets_.data(); }

  /// Of component i of n of entry e of a row.
  [[nodiscard]] size_t place(int row, int e, int i = 0, int n = 1) const {
    return place(offsets_.data(), row, e, i, n);
  }
  [[nodiscard]] static size_t place(const int* offsets, int row, int e, int i = 0, int n = 1) {
    const auto group = static_cast<size_t>(offsets[row / kSliceWidth]) + static_cast<size_t>(e);
    return (group * static_cast<size_t>(n) + static_cast<size_t>(i)) * kSliceWidth + row % kSliceWidth;
  }

 private:
  std::vector<int> offsets_{0};
};

/// The owner of a SlicedView: zeros, until entries are set.
template <class Real>
class SlicedNumbers {
 public:
  SlicedNumbers() = default;
  SlicedNumbers(const std::vector<int>& sizes, int threads);

  [[nodiscard]] const SliceLayout& layout() const { return layout_; }
  [[nodiscard]] SlicedView<Real> view() const { return {layout_.offsets(), indices_.data(), values_.data()}; }

  void set(int row, int e, int index, Real value) {
    indices_[layout_.place(row, e)] = index;
    values_[layout_.place(row, e)] = value;
  }

 private:
  SliceLayout layout_;
  AlignedBuffer<int> indices_;
  AlignedBuffer<Real> values_;
};

/// The owner of a SplitView: zeros, until entries are set. Slices may be those of another owner.
class SlicedVectors {
 public:
  SlicedVectors() = default;
  SlicedVectors(const std::vector<int>& sizes, int threads);
  /// @param lender  must outlive it, and has all its slices itself
  /// @param is_own  by slice; those of the lender's number that are not lent, and further ones
  /// @param sizes   entries of each row
  SlicedVectors(const SlicedVectors& lender, std::vector<char> is_own, const std::vector<int>& sizes, int threads);

  [[nodiscard]] int n_slices() const { return layout_.n_slices(); }
  /// About, where some are lent.
  [[nodiscard]] int n_groups() const { return layout_.n_groups() + n_lent_groups_; }
  [[nodiscard]] bool is_own(int slice) const { return is_own_.empty() || is_own_[slice] != 0; }

  /// f(view, begin, end) for slices [begin, end), in order, as many at once as one owner has.
  template <class Function>
  void for_each_view(int begin, int end, const Function& f) const {
    while (begin < end) {
      int next = is_own_.empty() ? end : begin + 1;
      while (next < end && is_own(next) == is_own(begin)) ++next;
      f(is_own(begin) ? view() : lent_, begin, next);
      begin = next;
    }
  }

  /// Of rows in slices of its own.
  void set(int row, int e, int index, const SplitVector& vector) {
    indices_[layout_.place(row, e)] = index;
    for (int i = 0; i < 3; ++i) {
      high_[layout_.place(row, e, i, 3)] = vector.high[i];
      low_[layout_.place(row, e, i, 3)] = vector.low[i];
    }
  }

  [[nodiscard]] int index(int row, int e) const {
    const SplitView from = view_of(row);
    return from.indices[SliceLayout::place(from.offsets, row, e)];
  }
  [[nodiscard]] Vector3 vector(int row, int e) const {
    const SplitView from = view_of(row);
    SplitVector vector;
    for (int i = 0; i < 3; ++i) {
      vector.high[i] = from.high[SliceLayout::place(from.offsets, row, e, i, 3)];
      vector.low[i] = from.low[SliceLayout::place(from.offsets, row, e, i, 3)];
    }
    return vector.whole();
  }

 private:
  [[nodiscard]] SplitView view() const { return {layout_.offsets(), indices_.data(), high_.data(), low_.data()}; }
  [[nodiscard]] SplitView view_of(int row) const { return is_own(row / kSliceWidth) ? view() : lent_; }

  SliceLayout layout_;        ///< of its own slices; the others have no groups
  std::vector<char> is_own_;  ///< by slice; empty: all are
  SplitView lent_{};
  int n_lent_groups_ = 0;
  AlignedBuffer<int> indices_;
  AlignedBuffer<float> high_;
  AlignedBuffer<std::int16_t> low_;
};

}  // namespace arap
