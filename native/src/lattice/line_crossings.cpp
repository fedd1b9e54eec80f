// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/line_crossings.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace arap {

namespace {

using Point = Eigen::Vector2d;

/// Twice the area of (a, b, p), and its sign for p moved by (e, e^2), e infinitely small: 0 only if a = b. The same for
/// both triangles at an edge, but for the sign.
struct Side {
  double area;
  int sign;

  Side(const Point& a, const Point& b, bool is_turned, const Point& p) {
    const Point edge = b - a;
    const Point to = p - a;
    area = edge[0] * to[1] - edge[1] * to[0];
    const double decides = area != 0 ? area : edge[1] != 0 ? -edge[1] : edge[0];
    sign = decides > 0 ? 1 : decides < 0 ? -1 : 0;
    if (!is_turned) return;
    area = -area;
    sign = -sign;
  }
};

class Lines {
 public:
  Lines(const Positions& points, const SampleBox& samples, int axis)
      : points_(points), samples_(samples), axis_(axis), axes_{(axis + 1) % 3, (axis + 2) % 3} {}

  void cross(const std::array<int, 3>& corners, int triangle, std::vector<Crossing>& crossings) const {
    std::array<int, 2> low{};
    std::array<int, 2> high{};
    for (int k = 0; k < 2; ++k) {
      const auto [least, most] = std::minmax({at(corners[0], k), at(corners[1], k), at(corners[2], k)});
      // A little more at both ends: rounding must not decide here what cross_at() decides.
      constexpr double kRounding = 1e-6;
      const int last = samples_.counts[axes_[k]] - 1;
      low[k] = static_cast<int>(std::clamp(std::ceil(number(k, least) - kRounding), 0.0, last + 1.0));
      high[k] = static_cast<int>(std::clamp(std::floor(number(k, most) + kRounding), -1.0, last + 0.0));
    }
    for (int i = low[0]; i <= high[0]; ++i)
      for (int j = low[1]; j <= high[1]; ++j) cross_at({i, j}, corners, triangle, crossings);
  }

 private:
  void cross_at(const std::array<int, 2>& line, const std::array<int, 3>& corners, int triangle,
                std::vector<Crossing>& crossings) const {
    const Point p(samples_.first[axes_[0]] + line[0] * samples_.spacing,
                  samples_.first[axes_[1]] + line[1] * samples_.spacing);
    std::array<double, 3> areas{};  // opposite to each corner
    int sign = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = corners[(k + 1) % 3];
      const int b = corners[(k + 2) % 3];
      const Side side = a < b ? Side(flat(a), flat(b), false, p) : Side(flat(b), flat(a), true, p);
      if (side.sign == 0 || (k > 0 && side.sign != sign)) return;
      sign = side.sign;
      areas[k] = side.area;
    }
    const double sum = areas[0] + areas[1] + areas[2];
    if (sum == 0) return;
    double place = 0;
    for (int k = 0; k < 3; ++k) place += areas[k] / sum * points_(corners[k], axis_);
    const auto before = std::floor((place - samples_.first[axis_]) / samples_.spacing);
    crossings.push_back(
        {line, static_cast<int>(std::clamp(before, -1.0, samples_.counts[axis_] - 1.0)), sign, triangle, place});
  }

  [[nodiscard]] double at(int vertex, int k) const { return points_(vertex, axes_[k]); }
  [[nodiscard]] Point flat(int vertex) const { return {at(vertex, 0), at(vertex, 1)}; }
  [[nodiscard]] double number(int k, double coordinate) const {
    return (coordinate - samples_.first[axes_[k]]) / samples_.spacing;
  }

  const Positions& points_;
  const SampleBox& samples_;
  int axis_;
  std::array<int, 2> axes_;
};

}  // namespace

std::vector<Crossing> find_crossings(const Positions& points, const std::vector<std::array<int, 3>>& triangles,
                                     const SampleBox& samples, int axis, const MeterPart& meter) {
  std::vector<Crossing> crossings;
  const Lines lines(points, samples, axis);
  const int n = static_cast<int>(triangles.size());
  for (int t = 0; t < n; ++t) {
    lines.cross(triangles[t], t, crossings);
    meter.add_nth(t, n);
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.line, a.place, a.triangle) < std::tie(b.line, b.place, b.triangle);
  });
  return crossings;
}

}  // namespace arap
