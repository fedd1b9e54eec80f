// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <utility>

namespace arap {

/// Whether two corners of a triangle are one vertex: it joins two vertices, and has no area.
[[nodiscard]] inline bool is_line(const std::array<int, 3>& triangle) {
  return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

/// The vertices of a line.
[[nodiscard]] inline std::pair<int, int> ends_of(const std::array<int, 3>& line) {
  return {line[0], line[0] == line[1] ? line[2] : line[1]};
}

}  // namespace arap
