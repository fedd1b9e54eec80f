// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/cube_pieces.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <iterator>
#include <span>
#include <tuple>
#include <utility>

#include "base/union_find.h"
#include "lattice/line_triangle.h"
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
  UnionFind joined{0};         ///< in one cube, and connected there
  std::vector<Pair> touching;  ///< in cubes side by side, and connected

  [[nodiscard]] int size() const { return joined.size(); }
  int add(int cube) {
    cubes.push_back(cube);
    return joined.add();
  }
  void connect(int a, int b) {
    if (cubes[a] == cubes[b])
      joined.join(a, b);
    else
      touching.emplace_back(a, b);
  }
};

/// The surface as things, but for triangles that are lines: see tie_lines.
class CutSurface {
 public:
  CutSurface(const Positions& points, const std::vector<Triangle>& triangles, const CubeGrid& grid, Things& things,
             const MeterPart& meter)
      : points_(points),
        triangles_(triangles),
        grid_(grid),
        things_(things),
        shells_(static_cast<int>(points.rows())),
        offsets_(triangles.size() + 1, 0) {
    for (Eigen::Index v = 0; v < points.rows(); ++v) things.add(grid.index(grid.cube_at(points.row(v))));
    const auto n = static_cast<int>(triangles.size());
    for (int t = 0; t < n; ++t) {
      const bool is_surface = !is_line(triangles[t]);
      for (int k = 1; is_surface && k < 3; ++k) shells_.join(triangles[t][0], triangles[t][k]);
      if (is_in_one_cube(triangles[t])) {
        for (int k = 1; k < 3; ++k) things.connect(triangles[t][0], triangles[t][k]);
      } else if (is_surface) {
        cut(triangles[t]);
      }
      offsets_[t + 1] = static_cast<int>(cut_.size());
      meter.add_nth(t, n);
    }
    join_edges();
  }

  /// Whether triangles hang together without lines.
  [[nodiscard]] bool are_of_one_shell(int a, int b) {
    return shells_.find(triangles_[a][0]) == shells_.find(triangles_[b][0]);
  }
  /// What the shells are that are turned outwards (way = 1) or inwards (-1).
  [[nodiscard]] std::vector<int> things_turned(int way) {
    std::vector<double> volumes(points_.rows(), 0);
    for (const auto& [a, b, c] : triangles_) {
      const int shell = shells_.find(a);
      const Eigen::RowVector3d origin = points_.row(shell);
      volumes[shell] +=
          (points_.row(a) - origin)
              .dot(Eigen::RowVector3d(points_.row(b) - origin).cross(Eigen::RowVector3d(points_.row(c) - origin)));
    }
    std::vector<int> result;
    for (Eigen::Index v = 0; v < points_.rows(); ++v)
      if (way * volumes[shells_.find(static_cast<int>(v))] > 0) result.push_back(static_cast<int>(v));
    for (size_t t = 0; t < triangles_.size(); ++t)
      if (way * volumes[shells_.find(triangles_[t][0])] > 0)
        for (int k = offsets_[t]; k < offsets_[t + 1]; ++k) result.push_back(cut_[k].thing);
    return result;
  }
  /// Makes things of a line.
  void cut_line(const Triangle& line) { cut_cubes(line); }

  /// What a triangle has at a point of it; -1 if rounding puts the point into a cube beside.
  [[nodiscard]] int thing_at(int triangle, const Eigen::RowVector3d& point) const {
    if (offsets_[triangle] == offsets_[triangle + 1]) return triangles_[triangle][0];
    return thing_in_cube(triangle, grid_.index(grid_.cube_at(point)));
  }
  /// What a triangle has in a cube; -1: nothing.
  [[nodiscard]] int thing_in_cube(int triangle, int cube) const {
    return find(static_cast<size_t>(offsets_[triangle]), static_cast<size_t>(offsets_[triangle + 1]), cube);
  }

 private:
  /// What a triangle has in a cube.
  struct Cut {
    int cube;
    int thing;
  };
  /// The same where one of its edges passes through a cube that has neither end of it; or a corner, a = b, touches one.
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
    const size_t first = cut_cubes(triangle);
    for (const int v : triangle) touch(v, first);
    for (int k = 0; k < 3; ++k) cut_edge(triangle[k], triangle[(k + 1) % 3], first);
  }

  /// Returns the first cut.
  size_t cut_cubes(const Triangle& triangle) {
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
    return first;
  }

  /// A corner on a wall is in one of the cubes beside, and touches the others. What triangles have there hangs together
  /// at the corner.
  void touch(int v, size_t first) {
    for (size_t k = first; k < cut_.size(); ++k)
      if (cut_[k].cube != things_.cubes[v] && grid_.touches(grid_.cube(cut_[k].cube), points_.row(v)))
        edges_.push_back({v, v, cut_[k].cube, cut_[k].thing});
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
  UnionFind shells_;          ///< vertices
  std::vector<int> offsets_;  ///< of each triangle in cut_; a triangle in one cube has none
  std::vector<Cut> cut_;      ///< by triangle, then by cube
  std::vector<EdgeCut> edges_;
  std::vector<Cube> cubes_;  ///< of the triangle or edge at hand
};

/// The inside as things.
class Inside {
 public:
  /// Makes things of the samples that are inside.
  Inside(const InsideSamples& inside, const CubeGrid& grid, Things& things)
      : inside_(inside), grid_(grid), things_(things) {
    first_things_.reserve(inside.cubes.size());
    for (size_t k = 0; k < inside.cubes.size(); ++k) {
      first_things_.push_back(things.size());
      for (int i = std::popcount(inside.bits[k]); i > 0; --i) things.add(inside.cubes[k]);
    }
  }

  /// Samples hang together if no triangle is between them, and with the surface if they see it from behind: a sample in
  /// a wall also sees what is in front of that. A wall between two shells may be too thin for samples: so there these
  /// hang together themselves.
  void connect(CutSurface& surface) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<Crossing>& crossings = inside_.crossings[axis];
      connect_samples(axis);
      for (size_t k = 0; k < crossings.size(); ++k) {
        const Crossing& crossing = crossings[k];
        const auto is_beside = [&](size_t other) {
          return other < crossings.size() && crossings[other].line == crossing.line &&
                 crossings[other].before == crossing.before;
        };
        const bool is_exit = crossing.sign == inside_.orientation;
        if (is_exit && !(k > 0 && is_beside(k - 1))) connect_to_surface(axis, crossing, crossing.before, surface);
        if (!is_exit && !is_beside(k + 1)) connect_to_surface(axis, crossing, crossing.before + 1, surface);
        const bool is_wall = !is_exit && is_beside(k + 1) && crossings[k + 1].sign == inside_.orientation;
        if (is_wall && !surface.are_of_one_shell(crossing.triangle, crossings[k + 1].triangle))
          connect_sides(axis, crossing, crossings[k + 1], surface);
      }
    }
  }

  /// A thing of the samples in a cube, if they are of one piece there; -1: they are not, or there are none.
  [[nodiscard]] int only_piece(int cube) const {
    const int k = inside_.find(cube);
    if (k < 0) return -1;
    UnionFind& sets = things_.joined;
    const int first = sets.find(first_things_[k]);
    for (int i = std::popcount(inside_.bits[k]) - 1; i > 0; --i)
      if (sets.find(first_things_[k] + i) != first) return -1;
    return first;
  }

 private:
  /// -1: the sample is outside.
  [[nodiscard]] int thing(int k, const std::array<int, 3>& sample) const {
    const SampleBits bit = SampleBits{1} << bit_of(sample);
    if (k < 0 || (inside_.bits[k] & bit) == 0) return -1;
    return first_things_[k] + std::popcount(inside_.bits[k] & (bit - 1));
  }

  /// Of the cubes that have samples inside, those samples that have a triangle before the next one along the axis.
  [[nodiscard]] std::vector<SampleBits> blocked(int axis) const {
    std::vector<SampleBits> result(inside_.cubes.size(), 0);
    for (const Crossing& crossing : inside_.crossings[axis]) {
      if (crossing.before < 0) continue;
      const std::array<int, 3> sample = sample_on(crossing.line, axis, crossing.before);
      if (const int k = inside_.find(grid_.index(cube_of(sample))); k >= 0)
        result[k] |= SampleBits{1} << bit_of(sample);
    }
    return result;
  }

  void connect_samples(int axis) {
    const std::vector<SampleBits> is_blocked = blocked(axis);
    for (size_t k = 0; k < inside_.cubes.size(); ++k) {
      const auto here = static_cast<int>(k);
      const Cube cube = grid_.cube(inside_.cubes[k]);
      Cube beside = cube;
      const int after = ++beside[axis] < grid_.counts[axis] ? inside_.find(grid_.index(beside)) : -1;
      Cube in_cube{};
      for (in_cube[0] = 0; in_cube[0] < kSamplesAlong; ++in_cube[0])
        for (in_cube[1] = 0; in_cube[1] < kSamplesAlong; ++in_cube[1])
          for (in_cube[2] = 0; in_cube[2] < kSamplesAlong; ++in_cube[2]) {
            Cube next = in_cube;
            const bool is_last = ++next[axis] == kSamplesAlong;
            const int a = thing(here, in_cube);
            const int b = thing(is_last ? after : here, next);
            if (a >= 0 && b >= 0 && (is_blocked[k] >> bit_of(in_cube) & 1) == 0) things_.connect(a, b);
          }
    }
  }

  void connect_to_surface(int axis, const Crossing& crossing, int s, const CutSurface& surface) {
    if (s < 0 || s >= inside_.samples.counts[axis]) return;
    const std::array<int, 3> sample = sample_on(crossing.line, axis, s);
    const int of_sample = thing(inside_.find(grid_.index(cube_of(sample))), sample);
    if (of_sample < 0) return;
    Eigen::RowVector3d place = inside_.samples.place(sample);
    place[axis] = crossing.place;
    const int of_surface = surface.thing_at(crossing.triangle, place);
    if (of_surface >= 0) things_.connect(of_sample, of_surface);
    // A place on a wall is in both cubes.
    const CubeGrid::Cube cube = cube_of(sample);
    const int beside = grid_.touches(cube, place) ? surface.thing_in_cube(crossing.triangle, grid_.index(cube)) : -1;
    if (beside >= 0) things_.connect(of_sample, beside);
  }

  /// What the two sides of a wall are where a line passes through it.
  void connect_sides(int axis, const Crossing& entry, const Crossing& exit, const CutSurface& surface) {
    Eigen::RowVector3d place = inside_.samples.place(sample_on(entry.line, axis, 0));
    place[axis] = entry.place;
    const int a = surface.thing_at(entry.triangle, place);
    place[axis] = exit.place;
    const int b = surface.thing_at(exit.triangle, place);
    if (a >= 0 && b >= 0) things_.connect(a, b);
  }

  const InsideSamples& inside_;
  const CubeGrid& grid_;
  Things& things_;
  std::vector<int> first_things_;  ///< of each cube that has samples inside
};

/// Joins the surfaces of voids to what is inside around them. A void may pass through a cube between the samples, and
/// would have a piece there that nothing but its neighbours holds.
void join_voids_to_inside(CutSurface& surface, const InsideSamples& samples, const Inside& inside, Things& things) {
  for (const int thing : surface.things_turned(-samples.orientation))
    if (const int around = inside.only_piece(things.cubes[thing]); around >= 0) things.connect(thing, around);
}

/// Cuts lines into things where nothing else ties their ends, as walls tie voids.
void tie_lines(const std::vector<Triangle>& lines, CutSurface& surface, Things& things) {
  UnionFind together = things.joined;
  for (const auto& [a, b] : things.touching) together.join(a, b);
  for (const Triangle& line : lines) {
    const auto [a, b] = ends_of(line);
    if (together.find(a) == together.find(b)) continue;
    surface.cut_line(line);
    together.join(a, b);
  }
}

/// Things that are joined are a piece. Pieces are in the order of their cubes.
CubePieces collect(Things& things, int n_vertices, int first_sample, const InsideSamples& inside) {
  const int n = things.size();
  UnionFind& sets = things.joined;
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
  pieces.samples.assign(pieces.cubes.size(), 0);
  int sample = first_sample;
  for (const SampleBits bits : inside.bits)
    for (SampleBits left = bits; left != 0; left &= left - 1)
      pieces.samples[piece_of[sample++]] |= left & (~left + 1);  // the lowest of those left
  for (auto& [a, b] : things.touching) {
    const auto [first, second] = std::minmax(piece_of[a], piece_of[b]);
    a = first;
    b = second;
  }
  pieces.beside = std::move(things.touching);
  std::sort(pieces.beside.begin(), pieces.beside.end());
  pieces.beside.erase(std::unique(pieces.beside.begin(), pieces.beside.end()), pieces.beside.end());
  piece_of.resize(n_vertices);
  pieces.piece_of_vertex = std::move(piece_of);
  return pieces;
}

}  // namespace

CubePieces find_pieces(const Positions& points, const std::vector<Triangle>& triangles, const CubeGrid& grid,
                       const MeterPart& meter) {
  Things things;
  CutSurface surface(points, triangles, grid, things, meter.part(0.4));
  const InsideSamples inside(points, triangles, grid, meter.part(0.5));
  const int first_sample = things.size();
  Inside things_inside(inside, grid, things);
  things_inside.connect(surface);
  std::vector<Triangle> lines;
  std::ranges::copy_if(triangles, std::back_inserter(lines), is_line);
  if (!lines.empty()) {
    join_voids_to_inside(surface, inside, things_inside, things);
    tie_lines(lines, surface, things);
  }
  CubePieces pieces = collect(things, static_cast<int>(points.rows()), first_sample, inside);
  meter.add(0.1);
  return pieces;
}

}  // namespace arap
