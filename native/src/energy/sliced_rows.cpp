// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/sliced_rows.h"

#include <algorithm>
#include <utility>

#include "parallel/parallel.h"

namespace arap {

namespace {

/// By all threads: memory that nothing has touched yet is the longest part of making it.
template <class Number>
AlignedBuffer<Number> zeros(size_t size, int threads) {
  constexpr int kBlock = 1 << 18;
  AlignedBuffer<Number> buffer(size);
  const auto n_blocks = static_cast<int>((size + kBlock - 1) / kBlock);
  for_each_piece(threads, n_blocks, [&](int block) {
    const size_t begin = static_cast<size_t>(block) * kBlock;
    std::fill_n(buffer.data() + begin, std::min<size_t>(kBlock, size - begin), Number{0});
  });
  return buffer;
}

/// Sizes of rows in these slices, 0 elsewhere.
std::vector<int> only(const std::vector<char>& slices, std::vector<int> sizes) {
  for (size_t row = 0; row < sizes.size(); ++row)
    if (slices[row / kSliceWidth] == 0) sizes[row] = 0;
  return sizes;
}

}  // namespace

SliceLayout::SliceLayout(const std::vector<int>& sizes) {
  offsets_.reserve(sizes.size() / kSliceWidth + 2);
  for (size_t first = 0; first < sizes.size(); first += kSliceWidth) {
    const auto begin = sizes.begin() + static_cast<std::ptrdiff_t>(first);
    const auto n = static_cast<std::ptrdiff_t>(std::min(size_t{kSliceWidth}, sizes.size() - first));
    offsets_.push_back(offsets_.back() + *std::max_element(begin, begin + n));
  }
}

template <class Real>
SlicedNumbers<Real>::SlicedNumbers(const std::vector<int>& sizes, int threads)
    : layout_(sizes),
      indices_(zeros<int>(layout_.n_entries(), threads)),
      values_(zeros<Real>(layout_.n_entries(), threads)) {}

SlicedVectors::SlicedVectors(const std::vector<int>& sizes, int threads)
    : layout_(sizes),
      indices_(zeros<int>(layout_.n_entries(), threads)),
      high_(zeros<float>(3 * layout_.n_entries(), threads)),
      low_(zeros<std::int16_t>(3 * layout_.n_entries(), threads)) {}

SlicedVectors::SlicedVectors(const SlicedVectors& lender, std::vector<char> is_own, const std::vector<int>& sizes,
                             int threads)
    : SlicedVectors(only(is_own, sizes), threads) {
  is_own_ = std::move(is_own);
  lent_ = lender.view();
  n_lent_groups_ = lender.n_groups();
}

template class SlicedNumbers<float>;
template class SlicedNumbers<double>;

}  // namespace arap
