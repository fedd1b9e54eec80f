// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace arap {

/// Numbers the vertices of a surface that are read in every frame, in the order in which they are first asked for: what
/// belongs together is near in memory, and what nothing hangs on costs nothing.
class UsedVertices {
 public:
  [[nodiscard]] int number_of(int vertex) {
    if (static_cast<size_t>(vertex) >= number_.size()) number_.resize(static_cast<size_t>(vertex) + 1, -1);
    int& number = number_[vertex];
    if (number < 0) {
      number = static_cast<int>(vertices_.size());
      vertices_.push_back(vertex);
    }
    return number;
  }
  [[nodiscard]] const std::vector<int>& vertices() const { return vertices_; }

 private:
  std::vector<int> number_;
  std::vector<int> vertices_;
};

}  // namespace arap
