// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/cube_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <span>
#include <tuple>

#include "base/union_find.h"
#include "lattice/line_crossings.h"
#include "lattice/triangle_cubes.h"

namespace arap {

namespace {

using Triangle = std::array<int, 3>;
using Cube = CubeGrid::Cube;
using Pair = std::pair<int, int>;

/// Things that each are in one cube: vertices, what a triangle has in a cube where it has no corner, and samples
/// inside.
struct Things {
  std::vector<int> cubes;      ///< of each thing
  std::vector<Pair> joined;    ///< in one cube, and connected there
  std::vector<Pair> touching;  ///< in cubes side by side, and connected

  int add(int cube) {
    cubes.push_back(cube);
    return static_cast<int>(cubes.size()) - 1;
  }
  void connect(int a, int b) { (cubes[a] == cubes[b] ? joined : touching).emplace_back(a, b); }
};

/// The surface as things.
class CutSurface {
 public:
  CutSurface(const Positions& points, const std::vector<Triangle>& triangles, const CubeGrid& grid, Things& things)
      : points_(points), triangles_(triangles), grid_(grid), things_(things), offsets_(triangles.size() + 1, 0) {
    for (Eigen::Index v = 0; v < points.rows(); ++v) things.add(grid.index(grid.cube_at(points.row(v))));
    for (size_t t = 0; t < triangles.size(); ++t) {
      if (is_in_one_cube(triangles[t])) {
        for (int k = 1; k < 3; ++k) things.connect(triangles[t][0], triangles[t][k]);
      } else {
        cut(triangles[t]);
      }
      offsets_[t + 1] = static_cast<int>(cut_.size());
    }
    join_edges();
  }

  /// What a triangle has at a point of it; -1 if rounding puts the point into a cube beside.
  [[nodiscard]] int thing_at(int triangle, const Eigen::RowVector3d& point) const {
    if (offsets_[triangle] == offsets_[triangle + 1]) return triangles_[triangle][0];
    return find(static_cast<size_t>(offsets_[triangle]), static_cast<size_t>(offsets_[triangle + 1]),
                grid_.index(grid_.cube_at(point)));
  }

 private:
  /// What a triangle has in a cube.
  struct Cut {
    int cube;
    int thing;
  };
  /// The same where one of its edges passes through a cube that has neither end of it.
  struct EdgeCut {
    int a;
    int b;
    int cube;
    int thing;
  };

  [[nodiscard]] bool is_in_one_cube(const Triangle& triangle) const {
    const std::vector<int>& cubes = things_.cubes;
    return cubes[triangle[0]] == cubes[triangle[1]] && cubes[triangle[0]] == cubes[triangle[2]];
  }

  void cut(const Triangle& triangle) {
    find_cubes(grid_, {points_.row(triangle[0]), points_.row(triangle[1]), points_.row(triangle[2])}, cubes_);
    for (const int v : triangle) cubes_.push_back(grid_.cube(things_.cubes[v]));
    std::sort(cubes_.begin(), cubes_.end());
    cubes_.erase(std::unique(cubes_.begin(), cubes_.end()), cubes_.end());
    const size_t first = cut_.size();
    for (const Cube& cube : cubes_) cut_.push_back({grid_.index(cube), thing_in(triangle, grid_.index(cube))});
    for (size_t k = 0; k < cubes_.size(); ++k)
      for (int axis = 0; axis < 3; ++axis) {
        Cube next = cubes_[k];
        ++next[axis];
        const auto found = std::lower_bound(cubes_.begin(), cubes_.end(), next);
        if (found != cubes_.end() && *found == next)
          things_.touching.emplace_back(cut_[first + k].thing,
                                        cut_[first + static_cast<size_t>(found - cubes_.begin())].thing);
      }
    for (int k = 0; k < 3; ++k) cut_edge(triangle[k], triangle[(k + 1) % 3], first);
  }

  /// A corner if the cube has one, else a new thing.
  int thing_in(const Triangle& triangle, int cube) {
    int thing = -1;
    for (const int v : triangle) {
      if (things_.cubes[v] != cube) continue;
      if (thing >= 0) things_.connect(thing, v);
      thing = v;
    }
    return thing >= 0 ? thing : things_.add(cube);
  }

  void cut_edge(int a, int b, size_t first) {
    const Cube at_a = grid_.cube(things_.cubes[a]);
    const Cube at_b = grid_.cube(things_.cubes[b]);
    int apart = 0;
    for (int k = 0; k < 3; ++k) apart += std::abs(at_a[k] - at_b[k]);
    if (apart < 2) return;
    find_cubes(grid_, {points_.row(a), points_.row(b), points_.row(b)}, cubes_);
    for (const Cube& cube : cubes_) {
      if (cube == at_a || cube == at_b) continue;
      const int index = grid_.index(cube);
      if (const int thing = find(first, cut_.size(), index); thing >= 0)
        edges_.push_back({std::min(a, b), std::max(a, b), index, thing});
    }
  }

  /// Triangles hang together where they have an edge in common.
  void join_edges() {
    const auto key = [](const EdgeCut& edge) { return std::tie(edge.a, edge.b, edge.cube); };
    std::sort(edges_.begin(), edges_.end(), [&](const EdgeCut& a, const EdgeCut& b) { return key(a) < key(b); });
    for (size_t k = 1; k < edges_.size(); ++k)
      if (key(edges_[k]) == key(edges_[k - 1])) things_.connect(edges_[k - 1].thing, edges_[k].thing);
    edges_ = {};
  }

  /// What one triangle's cuts [begin, end) have in a cube; -1: nothing.
  [[nodiscard]] int find(size_t begin, size_t end, int cube) const {
    const std::span<const Cut> cuts = std::span(cut_).subspan(begin, end - begin);
    const auto found = std::ranges::lower_bound(cuts, cube, {}, &Cut::cube);
    return found != cuts.end() && found->cube == cube ? found->thing : -1;
  }

  const Positions& points_;
  const std::vector<Triangle>& triangles_;
  const CubeGrid& grid_;
  Things& things_;
  std::vector<int> offsets_;  ///< of each triangle in cut_; a triangle in one cube has none
  std::vector<Cut> cut_;      ///< by triangle, then by cube
  std::vector<EdgeCut> edges_;
  std::vector<Cube> cubes_;  ///< of the triangle or edge at hand
};

/// Samples of all cubes that have some of the points.
SampleBox sample_box(const Positions& points, const CubeGrid& grid) {
  const Cube low = grid.cube_at(points.colwise().minCoeff());
  const Cube high = grid.cube_at(points.colwise().maxCoeff());
  SampleBox samples;
  samples.spacing = grid.size / kSamplesAlong;
  samples.first = grid.corner(low) + Eigen::RowVector3d::Constant(samples.spacing / 2);
  for (int k = 0; k < 3; ++k) samples.counts[k] = kSamplesAlong * (high[k] - low[k] + 1);
  return samples;
}

/// Calls visit(begin, end) for the crossings of each line.
template <class Visit>
void for_each_line(const std::vector<Crossing>& crossings, const Visit& visit) {
  for (size_t begin = 0; begin < crossings.size();) {
    size_t end = begin;
    while (end < crossings.size() && crossings[end].line == crossings[begin].line) ++end;
    visit(begin, end);
    begin = end;
  }
}

std::array<int, 3> sample_on(const std::array<int, 2>& line, int axis, int k) {
  std::array<int, 3> sample{};
  sample[axis] = k;
  sample[(axis + 1) % 3] = line[0];
  sample[(axis + 2) % 3] = line[1];
  return sample;
}

/// The inside as things.
class Inside {
 public:
  Inside(const Positions& points, const std::vector<Triangle>& triangles, const CubeGrid& grid)
      : samples_(sample_box(points, grid)), things_of_samples_(samples_.size(), 0) {
    for (int axis = 0; axis < 3; ++axis) crossings_[axis] = find_crossings(points, triangles, samples_, axis);
  }

  /// Makes things of the samples that are inside.
  void add_to(Things& things, const CubeGrid& grid, int orientation) {
    for (int axis = 0; axis < 3; ++axis) count_rays(axis, orientation);
    constexpr int kMostOfSix = 4;
    Cube sample{};
    for (sample[0] = 0; sample[0] < samples_.counts[0]; ++sample[0])
      for (sample[1] = 0; sample[1] < samples_.counts[1]; ++sample[1])
        for (sample[2] = 0; sample[2] < samples_.counts[2]; ++sample[2]) {
          int& thing = things_of_samples_[samples_.index(sample)];
          thing = thing >= kMostOfSix ? things.add(grid.index(grid.cube_at(samples_.place(sample)))) : kOutside;
        }
  }

  /// Samples hang together if no triangle is between them, and with the surface if they see it from behind: a sample in
  /// a wall also sees what is in front of that.
  void connect(Things& things, const CutSurface& surface, int orientation) const {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<char> is_blocked(samples_.size(), 0);
      for (const Crossing& crossing : crossings_[axis])
        if (crossing.before >= 0) is_blocked[samples_.index(sample_on(crossing.line, axis, crossing.before))] = 1;
      connect_samples(axis, is_blocked, things);
      for_each_line(crossings_[axis], [&](size_t begin, size_t end) {
        for (size_t k = begin; k < end; ++k) {
          const Crossing& crossing = crossings_[axis][k];
          const bool is_exit = crossing.sign == orientation;
          if (is_exit && (k == begin || crossings_[axis][k - 1].before != crossing.before))
            connect_to_surface(axis, crossing, crossing.before, surface, things);
          if (!is_exit && (k + 1 == end || crossings_[axis][k + 1].before != crossing.before))
            connect_to_surface(axis, crossing, crossing.before + 1, surface, things);
        }
      });
    }
  }

 private:
  static constexpr int kOutside = -1;

  /// Adds for each sample how many of the rays up and down the axis leave more often than they enter.
  void count_rays(int axis, int orientation) {
    const std::vector<Crossing>& crossings = crossings_[axis];
    for_each_line(crossings, [&](size_t begin, size_t end) {
      int left = 0;
      for (size_t k = begin; k < end; ++k) left += crossings[k].sign;
      const int all = left;
      size_t k = begin;
      for (int s = 0; s < samples_.counts[axis]; ++s) {
        for (; k < end && crossings[k].before < s; ++k) left -= crossings[k].sign;
        // Up: what is left. Down: what has passed, the other way round.
        int& n_rays = things_of_samples_[samples_.index(sample_on(crossings[begin].line, axis, s))];
        n_rays += (orientation * left > 0 ? 1 : 0) + (orientation * (left - all) > 0 ? 1 : 0);
      }
    });
  }

  void connect_samples(int axis, const std::vector<char>& is_blocked, Things& things) const {
    Cube sample{};
    for (sample[0] = 0; sample[0] < samples_.counts[0]; ++sample[0])
      for (sample[1] = 0; sample[1] < samples_.counts[1]; ++sample[1])
        for (sample[2] = 0; sample[2] < samples_.counts[2]; ++sample[2]) {
          Cube next = sample;
          if (++next[axis] == samples_.counts[axis]) continue;
          const size_t at = samples_.index(sample);
          const int a = things_of_samples_[at];
          const int b = things_of_samples_[samples_.index(next)];
          if (a != kOutside && b != kOutside && is_blocked[at] == 0) things.connect(a, b);
        }
  }

  void connect_to_surface(int axis, const Crossing& crossing, int s, const CutSurface& surface, Things& things) const {
    if (s < 0 || s >= samples_.counts[axis]) return;
    const std::array<int, 3> sample = sample_on(crossing.line, axis, s);
    const int thing = things_of_samples_[samples_.index(sample)];
    if (thing == kOutside) return;
    Eigen::RowVector3d place = samples_.place(sample);
    place[axis] = crossing.place;
    const int of_surface = surface.thing_at(crossing.triangle, place);
    if (of_surface >= 0) things.connect(thing, of_surface);
  }

  SampleBox samples_;
  std::array<std::vector<Crossing>, 3> crossings_;
  std::vector<int> things_of_samples_;  ///< first, how many rays say inside
};

/// -1 if the surface is turned inside out.
int orientation_of(const Positions& points, const std::vector<Triangle>& triangles) {
  double volume = 0;
  const Eigen::RowVector3d middle = points.colwise().mean();
  for (const Triangle& t : triangles)
    volume +=
        Eigen::RowVector3d(points.row(t[0]) - middle)
            .dot(Eigen::RowVector3d(points.row(t[1]) - middle).cross(Eigen::RowVector3d(points.row(t[2]) - middle)));
  return volume < 0 ? -1 : 1;
}

/// Things that are joined are a piece. Pieces are in the order of their cubes.
CubePieces collect(const Things& things, int n_vertices, int first_sample) {
  const auto n = static_cast<int>(things.cubes.size());
  UnionFind sets(n);
  for (const auto& [a, b] : things.joined) sets.join(a, b);
  std::vector<int> roots;
  for (int i = 0; i < n; ++i)
    if (sets.find(i) == i) roots.push_back(i);
  std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) { return things.cubes[a] < things.cubes[b]; });
  std::vector<int> piece_of(n, -1);
  CubePieces pieces;
  for (const int root : roots) {
    piece_of[root] = pieces.size();
    pieces.cubes.push_back(things.cubes[root]);
  }
  for (int i = 0; i < n; ++i) piece_of[i] = piece_of[sets.find(i)];
  pieces.inside.assign(pieces.cubes.size(), 0);
  constexpr double kShare = 1.0 / (kSamplesAlong * kSamplesAlong * kSamplesAlong);
  for (int i = first_sample; i < n; ++i) pieces.inside[piece_of[i]] += kShare;
  for (const auto& [a, b] : things.touching)
    pieces.beside.emplace_back(std::min(piece_of[a], piece_of[b]), std::max(piece_of[a], piece_of[b]));
  std::sort(pieces.beside.begin(), pieces.beside.end());
  pieces.beside.erase(std::unique(pieces.beside.begin(), pieces.beside.end()), pieces.beside.end());
  pieces.piece_of_vertex.assign(piece_of.begin(), piece_of.begin() + n_vertices);
  return pieces;
}

}  // namespace

CubePieces find_pieces(const Positions& points, const std::vector<Triangle>& triangles, const CubeGrid& grid) {
  Things things;
  const CutSurface surface(points, triangles, grid, things);
  Inside inside(points, triangles, grid);
  const auto first_sample = static_cast<int>(things.cubes.size());
  const int orientation = orientation_of(points, triangles);
  inside.add_to(things, grid, orientation);
  inside.connect(things, surface, orientation);
  return collect(things, static_cast<int>(points.rows()), first_sample);
}

}  // namespace arap
