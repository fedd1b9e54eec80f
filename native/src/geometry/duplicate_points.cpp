// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/duplicate_points.h"

#include <algorithm>
#include <limits>

#include "geometry/point_grid.h"
#include "parallel/parallel.h"

namespace arap {

std::vector<int> coincident_with(const Positions& positions, double distance, int threads, const MeterPart& meter) {
  const auto n = static_cast<int>(positions.rows());
  // Large compared to `distance`: a search looks at few cells. Small enough that few of the vertices in a cell do not
  // coincide, however crowded the mesh is.
  const double cell_size = std::max(8 * distance, std::numeric_limits<double>::min());
  const PointGrid grid(positions, cell_size, threads);
  const auto find_before = [&](int v, const auto& is_wanted) {
    // A ball that contains the cube.
    return grid.find_near(positions.row(v), 2 * distance, [&](int u, double) {
      return u < v && (positions.row(u) - positions.row(v)).cwiseAbs().maxCoeff() <= distance && is_wanted(u);
    });
  };
  constexpr double kSearch = 0.7;  // of the time
  std::vector<int> lowest(n);
  std::vector<char> has_near(n);
  parallel_for(threads, n, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      lowest[v] = v;
      has_near[v] = static_cast<char>(find_before(v, [](int) { return true; }) >= 0);
    }
    meter.add(kSearch * (end - begin) / n);
  });
  const MeterPart choice = meter.part(1 - kSearch);
  for (int v = 0; v < n; ++v) {
    choice.add_nth(v, n);
    if (has_near[v] == 0) continue;
    // A vertex that maps to another one does not count: that one may be farther away.
    const int near = find_before(v, [&](int u) { return lowest[u] == u; });
    if (near >= 0) lowest[v] = near;
  }
  return lowest;
}

}  // namespace arap
