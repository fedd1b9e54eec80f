// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/carried_points.h"

#include "models/input_checks.h"

namespace arap {

void require_points(const Positions& points, const char* carrier) {
  if (points.rows() == 0)
    throw InvalidInput(text("points is empty; give at least one point for the ", carrier, " to move"));
  if (points.rows() > kMostVertices)
    throw InvalidInput(text("points has ", points.rows(), " rows, must have at most ", kMostVertices));
  require_finite("points", points, [](int k) { return text("row ", k); });
}

void require_moved(const char* what, const Positions& positions, int n_vertices) {
  require_rows(what, positions.rows(), n_vertices);
  require_finite(what, positions, [](int v) { return text("vertex ", v); });
}

void require_three_numbers(const char* what, size_t size, const char* noun, int n) {
  const size_t n_numbers = 3 * static_cast<size_t>(n);
  if (size != n_numbers)
    throw InvalidInput(text(what, " has ", size, " numbers, must have three per ", noun, ", ", n_numbers));
}

SinglePoints::SinglePoints(const char* what, std::span<float> out, int n_points) : what_(what), out_(out) {
  require_three_numbers("out", out.size(), "point", n_points);
}

void SinglePoints::require_finite() const {
  if (!is_finite_)
    throw InvalidInput(text(what_, " move points beyond the range of single precision; look for positions far away"));
}

}  // namespace arap
