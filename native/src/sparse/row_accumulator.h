// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

namespace arap {

/// A sparse row under construction: values by column, columns in order of first use.
template <class Value>
class RowAccumulator {
 public:
  using Entry = std::pair<int, Value>;

  explicit RowAccumulator(int n_columns) : slot_(n_columns, -1) {}

  /// The value of a column; adds it as 0 if it is new.
  Value& operator[](int column) {
    int& slot = slot_[column];
    if (slot < 0) {
      slot = static_cast<int>(entries_.size());
      entries_.emplace_back(column, zero());
    }
    return entries_[slot].second;
  }

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

  /// Sorts the columns. No column may be used afterwards, except after clear().
  void sort() {
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.first < b.first; });
  }

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

  std::vector<int> slot_;  ///< index of each column in entries_, or -1
  std::vector<Entry> entries_;
};

}  // namespace arap
