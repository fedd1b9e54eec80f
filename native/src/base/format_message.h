// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sstream>
#include <string>

namespace arap {

/// Concatenates the values as a stream prints them; for error messages.
template <class... Values>
[[nodiscard]] std::string text(const Values&... values) {
  std::ostringstream stream;
  (stream << ... << values);
  return stream.str();
}

}  // namespace arap
