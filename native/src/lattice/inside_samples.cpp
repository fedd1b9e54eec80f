// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/inside_samples.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

#include "base/available_memory.h"

namespace arap {

namespace {

using Cube = CubeGrid::Cube;
using Triangles = std::vector<std::array<int, 3>>;

constexpr int kSamples = kSamplesAlong * kSamplesAlong * kSamplesAlong;

SampleBox samples_of(const CubeGrid& grid) {
  SampleBox samples;
  samples.spacing = grid.size / kSamplesAlong;
  samples.first = grid.origin + Eigen::RowVector3d::Constant(samples.spacing / 2);
  for (int k = 0; k < 3; ++k) samples.counts[k] = kSamplesAlong * grid.counts[k];
  return samples;
}

/// Calls visit(line, crossings) for each line.
template <class Visit>
void for_each_line(const std::vector<Crossing>& crossings, const Visit& visit) {
  for (size_t begin = 0; begin < crossings.size();) {
    size_t end = begin;
    while (end < crossings.size() && crossings[end].line == crossings[begin].line) ++end;
    visit(crossings[begin].line, std::span(crossings).subspan(begin, end - begin));
    begin = end;
  }
}

/// How often a line leaves more often than it enters.
int sum_of(std::span<const Crossing> line) {
  return std::accumulate(line.begin(), line.end(), 0, [](int sum, const Crossing& at) { return sum + at.sign; });
}

/// Cubes in a row along an axis.
struct Run {
  int u;  ///< along the two next axes
  int v;
  int first;
  int last;
  [[nodiscard]] auto key() const { return std::tie(u, v, first); }
};

/// Those between walls: both rays along the axis leave more often than they enter, or both enter.
std::vector<Run> runs_between_walls(const std::vector<Crossing>& crossings) {
  std::vector<Run> runs;
  for_each_line(crossings, [&](const std::array<int, 2>& line, std::span<const Crossing> on_line) {
    const int all = sum_of(on_line);
    int passed = 0;
    for (size_t k = 1; k < on_line.size(); ++k) {
      passed += on_line[k - 1].sign;
      const int up = all - passed;
      const bool is_between = (up > 0 && -passed > 0) || (up < 0 && -passed < 0);
      const int first = on_line[k - 1].before + 1;
      const int last = on_line[k].before;
      if (is_between && first <= last)
        runs.push_back({line[0] / kSamplesAlong, line[1] / kSamplesAlong, first / kSamplesAlong, last / kSamplesAlong});
    }
  });
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.key() < b.key(); });
  std::vector<Run> merged;
  for (const Run& run : runs) {
    if (!merged.empty() && merged.back().u == run.u && merged.back().v == run.v && run.first <= merged.back().last + 1)
      merged.back().last = std::max(merged.back().last, run.last);
    else
      merged.push_back(run);
  }
  return merged;
}

/// In ascending order; none if they are too many.
std::vector<int> cubes_between_walls(const InsideSamples& inside, const CubeGrid& grid) {
  constexpr std::size_t kMost = 2'000'000;
  std::vector<int> cubes;
  for (int axis = 0; axis < 3; ++axis)
    for (const Run& run : runs_between_walls(inside.crossings[axis])) {
      if (cubes.size() > 3 * kMost) return {};
      for (int k = run.first; k <= run.last; ++k) cubes.push_back(grid.index(sample_on({run.u, run.v}, axis, k)));
    }
  std::sort(cubes.begin(), cubes.end());
  cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
  if (cubes.size() > kMost) cubes.clear();
  return cubes;
}

/// Of each sample of some cubes, how many of its six rays leave more often than they enter, and the other way round.
class Rays {
 public:
  Rays(const std::vector<int>& cubes, const CubeGrid& grid) : cubes_(cubes), grid_(grid) {
    for (auto& side : counts_) side.resize(cubes.size());
  }

  void count(const std::vector<Crossing>& crossings, int axis) {
    // Cubes column by column.
    const auto key_of = [&](const Cube& cube) {
      return (cube[(axis + 1) % 3] * grid_.counts[(axis + 2) % 3] + cube[(axis + 2) % 3]) * grid_.counts[axis] +
             cube[axis];
    };
    std::vector<std::pair<int, int>> column(cubes_.size());
    for (size_t k = 0; k < cubes_.size(); ++k) column[k] = {key_of(grid_.cube(cubes_[k])), static_cast<int>(k)};
    std::sort(column.begin(), column.end());
    for_each_line(crossings, [&](const std::array<int, 2>& line, std::span<const Crossing> on_line) {
      const int bottom = key_of(cube_of(sample_on(line, axis, 0)));
      const int all = sum_of(on_line);
      int up = all;
      size_t next = 0;
      for (auto at = std::lower_bound(column.begin(), column.end(), std::pair(bottom, 0));
           at != column.end() && at->first < bottom + grid_.counts[axis]; ++at)
        for (int k = 0; k < kSamplesAlong; ++k) {
          const int s = kSamplesAlong * (at->first - bottom) + k;
          for (; next < on_line.size() && on_line[next].before < s; ++next) up -= on_line[next].sign;
          const int bit = bit_of(sample_on(line, axis, s));
          for (const int way : {up, up - all})
            if (way != 0) ++counts_[way > 0 ? 0 : 1][at->second][bit];
        }
    });
  }

  /// Samples that most rays of one kind say are inside: 0 of a surface that is as it should be, 1 turned inside out.
  [[nodiscard]] std::vector<SampleBits> most(int side) const {
    constexpr int kMostOfSix = 4;
    std::vector<SampleBits> result(cubes_.size(), 0);
    for (size_t k = 0; k < cubes_.size(); ++k)
      for (int bit = 0; bit < kSamples; ++bit)
        if (counts_[side][k][bit] >= kMostOfSix) result[k] |= SampleBits{1} << bit;
    return result;
  }

 private:
  const std::vector<int>& cubes_;
  const CubeGrid& grid_;
  std::array<std::vector<std::array<std::uint8_t, kSamples>>, 2> counts_;
};

std::int64_t n_samples(const std::vector<SampleBits>& bits) {
  return std::accumulate(bits.begin(), bits.end(), std::int64_t{0},
                         [](std::int64_t n, SampleBits of_cube) { return n + std::popcount(of_cube); });
}

bool is_open(const InsideSamples& inside) {
  bool result = false;
  for (const std::vector<Crossing>& crossings : inside.crossings)
    for_each_line(crossings, [&](const std::array<int, 2>& /*line*/, std::span<const Crossing> on_line) {
      result = result || sum_of(on_line) != 0;
    });
  return result;
}

/// How large the opening is, as a part of the surface: 0 if that is closed, 1 of a plane.
double opening(const Positions& points, const Triangles& triangles) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double area = 0;
  for (const auto& [a, b, c] : triangles) {
    const Eigen::RowVector3d normal =
        Eigen::RowVector3d(points.row(b) - points.row(a)).cross(Eigen::RowVector3d(points.row(c) - points.row(a)));
    sum += normal;
    area += normal.norm();
  }
  return area > 0 ? sum.norm() / area : 1;
}

}  // namespace

InsideSamples::InsideSamples(const Positions& points, const Triangles& triangles, const CubeGrid& grid,
                             const MeterPart& meter)
    : samples(samples_of(grid)) {
  for (int axis = 0; axis < 3; ++axis)
    crossings[axis] = find_crossings(points, triangles, samples, axis, meter.part(0.3));
  const std::vector<int> between = cubes_between_walls(*this, grid);
  constexpr double kBytesPerCube = 200;  // rays of its samples, and what they tell
  require_memory(kBytesPerCube * static_cast<double>(between.size()), "what is inside of this mesh");
  Rays rays(between, grid);
  for (int axis = 0; axis < 3; ++axis) rays.count(crossings[axis], axis);
  std::array<std::vector<SampleBits>, 2> sides{rays.most(0), rays.most(1)};
  std::array<std::int64_t, 2> counts{n_samples(sides[0]), n_samples(sides[1])};
  if (counts[1] > counts[0]) {
    orientation = -1;
    std::swap(sides[0], sides[1]);
    std::swap(counts[0], counts[1]);
  }
  meter.add(0.1);
  // Half a body, cut at its mirror plane, has an opening of a third of its surface; half a ball, of a half.
  constexpr double kWide = 0.75;
  constexpr std::int64_t kBothSides = 4;
  if (is_open(*this) && (kBothSides * counts[1] > counts[0] || opening(points, triangles) > kWide)) return;
  for (size_t k = 0; k < between.size(); ++k) {
    if (sides[0][k] == 0) continue;
    cubes.push_back(between[k]);
    bits.push_back(sides[0][k]);
  }
}

int InsideSamples::find(int cube) const {
  const auto found = std::lower_bound(cubes.begin(), cubes.end(), cube);
  return found != cubes.end() && *found == cube ? static_cast<int>(found - cubes.begin()) : -1;
}

}  // namespace arap
