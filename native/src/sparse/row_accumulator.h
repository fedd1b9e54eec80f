// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

namespace arap {

/// A sparse row under construction: values by column, with the columns in the order in which they were first named.
template <class Value>
class RowAccumulator {
 public:
  using Entry = std::pair<int, Value>;

  explicit RowAccumulator(int n_columns) : slot_(n_columns, -1) {}

  /// 0 where it is new.
  Value& operator[](int column) {
    int& slot = slot_[column];
    if (slot < 0) {
      slot = static_cast<int>(entries_.size());
      entries_.emplace_back(column, zero());
    }
    return entries_[slot].second;
  }

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

  /// Puts the columns in their own order. Nothing may be added afterwards.
  void sort() {
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.first < b.first; });
  }

  /// Starts anew.
  void clear() {
    for (const Entry& entry : entries_) slot_[entry.first] = -1;
    entries_.clear();
  }

 private:
  static Value zero() {
    if constexpr (std::is_arithmetic_v<Value>)
      return 0;
    else
      return Value::Zero();
  }

  std::vector<int> slot_;  ///< of each column in entries_, or -1
  std::vector<Entry> entries_;
};

}  // namespace arap
