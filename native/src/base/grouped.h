// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "base/offsets.h"

namespace arap {

/// Items by the group that they are in; an item may be in several.
class Grouped {
 public:
  /// @param for_each  for_each(add) calls add(group, item) for all of them, and is called twice. Items of a group keep
  ///     this order
  template <class ForEach>
  Grouped(int n_groups, const ForEach& for_each) : offsets_(n_groups + 1, 0) {
    for_each([&](int group, int /*item*/) { ++offsets_[group + 1]; });
    make_offsets(offsets_);
    items_.resize(offsets_.back());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for_each([&](int group, int item) { items_[next[group]++] = item; });
  }

  [[nodiscard]] std::span<const int> of(int group) const {
    return std::span(items_).subspan(offsets_[group], offsets_[group + 1] - offsets_[group]);
  }

 private:
  std::vector<int> offsets_{0};
  std::vector<int> items_;
};

}  // namespace arap
