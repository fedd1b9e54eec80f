// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "arap/cage.h"
#include "base/available_memory.h"
#include "base/grouped.h"
#include "base/option_bounds.h"
#include "geometry/nearest_in_triangle.h"
#include "lattice/cube_grid.h"
#include "lattice/triangle_cubes.h"
#include "mesh/surface_measures.h"
#include "parallel/meter.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;
using Cube = CubeGrid::Cube;

/// Distances are in cubes. A cube is solid if the mesh is so near, along each axis.
constexpr double kMargin = .3;
/// What smoothing leaves of that.
constexpr double kLeastDistance = .25;
constexpr int kSteps = 4;
/// The farthest that a vertex moves in a step: less than the distance, so that it cannot jump over the mesh.
constexpr double kLongestStep = .2;

using Triangle = std::array<Row, 3>;

/// Those of the fans of all faces, in a box around the origin whose longest side is 1: of a mesh of any size, products
/// of lengths neither overflow nor vanish there.
struct UnitMesh {
  Row center;
  double size;
  std::vector<Triangle> triangles;
  Eigen::AlignedBox3d box;

  explicit UnitMesh(const PolygonMesh& mesh)
      : center(surface_box(mesh).center().transpose()), size(surface_box(mesh).sizes().maxCoeff()) {
    const auto place = [&](int v) { return Row((mesh.positions().row(v) - center) / size); };
    for (int f = 0; f < mesh.n_faces(); ++f)
      for_each_in_fan(mesh.face(f), [&](int i, int j, int k) { triangles.push_back({place(i), place(j), place(k)}); });
    for (const Triangle& triangle : triangles)
      for (const Row& corner : triangle) box.extend(corner.transpose());
  }

  template <class Visit>
  void for_each_triangle(const MeterPart& meter, const Visit& visit) const {
    const auto n = static_cast<int>(triangles.size());
    for (int t = 0; t < n; ++t) {
      visit(triangles[t]);
      meter.add_nth(t, n);
    }
  }
};

/// Solid cubes around and inside of a mesh.
class SolidCubes {
 public:
  /// @param room  empty cubes on each side of the mesh, for contacts to fill
  SolidCubes(const UnitMesh& mesh, double size, int room, const MeterPart& meter) {
    Eigen::AlignedBox3d box = mesh.box;
    box.min().array() -= room * size;
    box.max().array() += room * size;
    grid_ = grid_around(box, size);
    is_solid_.assign(static_cast<size_t>(grid_.counts[0]) * grid_.counts[1] * grid_.counts[2], 0);
    add_surface(mesh, meter);
    do fill_inside();
    while (fill_contacts());
  }

  [[nodiscard]] const CubeGrid& grid() const { return grid_; }
  [[nodiscard]] bool is_solid(const Cube& cube) const { return is_solid_[grid_.index(cube)] != 0; }

  /// Whether one is at the end of the grid, where a face would have nothing beside it.
  [[nodiscard]] bool fills_room() const {
    for (int k = 0; k < static_cast<int>(is_solid_.size()); ++k) {
      const Cube cube = grid_.cube(k);
      for (int axis = 0; axis < 3; ++axis)
        if (is_solid_[k] != 0 && (cube[axis] == 0 || cube[axis] + 1 == grid_.counts[axis])) return true;
    }
    return false;
  }

  template <class Visit>
  void for_each(const Visit& visit) const {
    for (int k = 0; k < static_cast<int>(is_solid_.size()); ++k)
      if (is_solid_[k] != 0) visit(grid_.cube(k));
  }

 private:
  /// A mesh moved by the margin along all axes, in either direction each, meets the cubes that are so near.
  void add_surface(const UnitMesh& mesh, const MeterPart& meter) {
    std::vector<Cube> cubes;
    mesh.for_each_triangle(meter, [&](const Triangle& corners) {
      for (int way = 0; way < 8; ++way) {
        const auto side = [&](int axis) { return (way >> axis) % 2 == 0 ? -1.0 : 1.0; };
        const Row shift = kMargin * grid_.size * Row(side(0), side(1), side(2));
        find_cubes(grid_, {corners[0] + shift, corners[1] + shift, corners[2] + shift}, cubes);
        for (const Cube& cube : cubes) is_solid_[grid_.index(cube)] = 1;
      }
    });
  }

  /// All that cannot be reached from the corner of the grid.
  void fill_inside() {
    std::vector<char> is_outside(is_solid_.size(), 0);
    std::vector<int> open{0};
    is_outside[0] = 1;
    while (!open.empty()) {
      const Cube cube = grid_.cube(open.back());
      open.pop_back();
      for (int axis = 0; axis < 3; ++axis)
        for (const int step : {-1, 1}) {
          Cube next = cube;
          next[axis] += step;
          if (next[axis] < 0 || next[axis] >= grid_.counts[axis]) continue;
          const int k = grid_.index(next);
          if (is_solid_[k] != 0 || is_outside[k] != 0) continue;
          is_outside[k] = 1;
          open.push_back(k);
        }
    }
    for (size_t k = 0; k < is_solid_.size(); ++k) is_solid_[k] = is_outside[k] != 0 ? 0 : 1;
  }

  /// Joins what is solid in the blocks of eight cubes whose solid or empty cubes touch at edges or corners alone, in
  /// all at once. There the surface would not be a manifold.
  bool fill_contacts() {
    std::vector<Cube> blocks;
    Cube low{};
    for (low[0] = 0; low[0] + 1 < grid_.counts[0]; ++low[0])
      for (low[1] = 0; low[1] + 1 < grid_.counts[1]; ++low[1])
        for (low[2] = 0; low[2] + 1 < grid_.counts[2]; ++low[2])
          if (!is_joined(low, true) || !is_joined(low, false)) blocks.push_back(low);
    std::vector<int> joints;
    for (const Cube& block : blocks) add_joints(block, joints);
    for (const int cube : joints) is_solid_[cube] = 1;
    return !blocks.empty();
  }

  /// The empty cubes of a block that join two of its solid ones; all that are empty if none does. To fill more would
  /// make contacts of its own, and a thin wavy sheet thick.
  void add_joints(const Cube& block, std::vector<int>& joints) const {
    const auto is_filled = [&](int k) { return is_solid(in_block(block, k)); };
    const size_t n_before = joints.size();
    for (const int least : {2, 0}) {
      for (int k = 0; k < 8; ++k)
        if (!is_filled(k) && is_filled(k ^ 1) + is_filled(k ^ 2) + is_filled(k ^ 4) >= least)
          joints.push_back(grid_.index(in_block(block, k)));
      if (joints.size() > n_before) return;
    }
  }

  static Cube in_block(const Cube& low, int k) { return {low[0] + k / 4, low[1] + k / 2 % 2, low[2] + k % 2}; }

  /// Whether the cubes of a block that are solid, or those that are not, hang together by faces.
  [[nodiscard]] bool is_joined(const Cube& low, bool wanted) const {
    unsigned members = 0;
    for (int k = 0; k < 8; ++k)
      if (is_solid(in_block(low, k)) == wanted) members |= 1U << static_cast<unsigned>(k);
    unsigned reached = members & (~members + 1);
    for (unsigned before = 0; before != reached;) {
      before = reached;
      for (unsigned k = 0; k < 8; ++k)
        if ((reached >> k & 1U) != 0)
          for (const unsigned step : {1U, 2U, 4U}) reached |= (1U << (k ^ step)) & members;
    }
    return reached == members;
  }

  CubeGrid grid_;
  std::vector<char> is_solid_;
};

/// The faces between solid cubes and others.
struct Quads {
  std::vector<Row> places;
  std::vector<std::array<int, 4>> faces;

  explicit Quads(const SolidCubes& cubes) {
    std::map<Cube, int> vertices;
    const auto vertex = [&](const Cube& corner) {
      const auto [found, is_new] = vertices.try_emplace(corner, static_cast<int>(places.size()));
      if (is_new) places.push_back(cubes.grid().corner(corner));
      return found->second;
    };
    cubes.for_each([&](const Cube& cube) {
      for (int axis = 0; axis < 3; ++axis)
        for (const int side : {0, 1}) {
          Cube beside = cube;
          beside[axis] += 2 * side - 1;
          if (cubes.is_solid(beside)) continue;
          std::array<int, 4> face{};
          constexpr std::array<std::array<int, 2>, 4> kAround{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
          for (int k = 0; k < 4; ++k) {
            Cube corner = cube;
            corner[axis] += side;
            const auto& at = kAround[side == 1 ? k : 3 - k];
            corner[(axis + 1) % 3] += at[0];
            corner[(axis + 2) % 3] += at[1];
            face[k] = vertex(corner);
          }
          faces.push_back(face);
        }
    });
  }
};

/// Moves the vertices of a cage towards the middles of their neighbours, as far as the mesh allows.
class Smoother {
 public:
  Smoother(Quads& quads, const UnitMesh& mesh, const CubeGrid& grid, const MeterPart& meter)
      : quads_(quads),
        grid_(grid),
        samples_(samples_of(mesh, grid, meter)),
        samples_of_cube_(grid.counts[0] * grid.counts[1] * grid.counts[2],
                         [&](const auto& add) {
                           for (int s = 0; s < static_cast<int>(samples_.size()); ++s)
                             add(grid.index(grid.cube_at(samples_[s])), s);
                         }),
        faces_of_(static_cast<int>(quads.places.size()), [&](const auto& add) {
          for (int f = 0; f < static_cast<int>(quads.faces.size()); ++f)
            for (const int v : quads.faces[f]) add(v, f);
        }) {}

  void step(const MeterPart& meter) {
    std::vector<Row> goals;
    goals.reserve(quads_.places.size());
    for (int v = 0; v < static_cast<int>(quads_.places.size()); ++v) goals.push_back(goal(v));
    for (size_t v = 0; v < goals.size(); ++v) {
      move(static_cast<int>(v), goals[v]);
      meter.add(1.0 / static_cast<double>(goals.size()));
    }
  }

 private:
  /// So near to each other that none of the mesh is farther than a tenth of a cube from one. Rows of them go from the
  /// shortest edge of a triangle: a long thin one has few. Tiny triangles of a dense mesh share one in each small cell.
  static std::vector<Row> samples_of(const UnitMesh& mesh, const CubeGrid& grid, const MeterPart& meter) {
    constexpr double kTiny = .05;
    constexpr int kCells = 33;  // along a cube: so a corner is .05 cubes from the one of its cell at most
    const double cube = grid.size;
    const CubeGrid cells{
        grid.origin, cube / kCells, {kCells * grid.counts[0], kCells * grid.counts[1], kCells * grid.counts[2]}};
    std::set<Cube> taken;
    const auto steps = [&](const Row& way) {
      return std::max(1, static_cast<int>(std::ceil(way.norm() / (.15 * cube))));
    };
    /// Of the shortest edge and the longest.
    const auto lengths = [](const Triangle& c) {
      return std::minmax({(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()});
    };
    double most = 0;
    for (const Triangle& c : mesh.triangles) {
      const auto [shortest, longest] = lengths(c);
      most += longest <= kTiny * cube ? 1 : (2 + shortest / (.15 * cube)) * (2 + longest / (.15 * cube));
    }
    constexpr double kBytesPerSample = 60;  // in the list, and in that of a cube
    require_memory(kBytesPerSample * most, "a cage around so many faces of this size");
    std::vector<Row> samples;
    mesh.for_each_triangle(meter, [&](const Triangle& c) {
      if (lengths(c).second <= kTiny * cube) {
        if (taken.insert(cells.cube_at(c[0])).second) samples.push_back(c[0]);
        return;
      }
      int first = 0;
      for (int k = 1; k < 3; ++k)
        if ((c[(k + 1) % 3] - c[k]).norm() < (c[(first + 1) % 3] - c[first]).norm()) first = k;
      const Row across = c[(first + 1) % 3] - c[first];
      const Row along = c[(first + 2) % 3] - c[first];
      const int n_rows = steps(across);
      for (int i = 0; i <= n_rows; ++i) {
        const double share = static_cast<double>(i) / n_rows;
        const Row row = (1 - share) * along;
        const int n = steps(row);
        for (int j = 0; j <= n; ++j) samples.emplace_back(c[first] + share * across + j * row / n);
      }
    });
    return samples;
  }

  [[nodiscard]] Row goal(int v) const {
    Row sum = Row::Zero();
    for (const int f : faces_of_.of(v))
      for (const int w : quads_.faces[f]) sum += quads_.places[w];
    const Row way = sum / (4. * static_cast<double>(faces_of_.of(v).size())) - quads_.places[v];
    return quads_.places[v] + way * std::min(1.0, kLongestStep * grid_.size / std::max(way.norm(), 1e-300));
  }

  void move(int v, const Row& goal) {
    const Row from = quads_.places[v];
    constexpr int kHalvings = 4;
    for (int k = 0; k < kHalvings; ++k) {
      quads_.places[v] = from + std::ldexp(1.0, -k) * (goal - from);
      if (is_free(v)) return;
    }
    quads_.places[v] = from;
  }

  /// Whether the mesh is far enough from the faces at a vertex, however they are cut.
  [[nodiscard]] bool is_free(int v) const {
    return std::ranges::none_of(faces_of_.of(v), [&](int f) { return is_near(f); });
  }

  /// Whether the mesh is too near to a face.
  [[nodiscard]] bool is_near(int f) const {
    const auto corner = [&](int k) { return Vector3(quads_.places[quads_.faces[f][k % 4]].transpose()); };
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 4; ++k) box.extend(corner(k));
    box.min().array() -= kLeastDistance * grid_.size;
    box.max().array() += kLeastDistance * grid_.size;
    const auto is_near_to = [&](const Vector3& sample) {
      if (!box.contains(sample)) return false;
      for (int k = 0; k < 4; ++k) {
        const Vector3 nearest = nearest_in_triangle(sample, corner(k), corner(k + 1), corner(k + 2));
        if ((sample - nearest).norm() < kLeastDistance * grid_.size) return true;
      }
      return false;
    };
    const Cube low = grid_.cube_at(box.min().transpose());
    const Cube high = grid_.cube_at(box.max().transpose());
    Cube cube{};
    for (cube[0] = low[0]; cube[0] <= high[0]; ++cube[0])
      for (cube[1] = low[1]; cube[1] <= high[1]; ++cube[1])
        for (cube[2] = low[2]; cube[2] <= high[2]; ++cube[2])
          for (const int s : samples_of_cube_.of(grid_.index(cube)))
            if (is_near_to(samples_[s])) return true;
    return false;
  }

  Quads& quads_;
  const CubeGrid& grid_;
  std::vector<Row> samples_;
  Grouped samples_of_cube_;
  Grouped faces_of_;
};

}  // namespace

inline namespace ARAP_COMPILED_ALIKE {

PolygonMesh make_cage(const PolygonMesh& mesh, int cells, const Progress& progress) {
  constexpr int kFewest = 2;
  constexpr int kMost = 50;
  require_between("cells", cells, kFewest, kMost);
  require_surface(mesh);
  const UnitMesh unit(mesh);
  const double size = 1. / cells;
  Meter meter(progress, "making the cage was cancelled");
  const MeterPart whole{&meter, 1};
  int room = 2;
  SolidCubes cubes(unit, size, room, whole.part(.6));
  while (cubes.fills_room()) cubes = SolidCubes(unit, size, room *= 2, whole.part(0));
  Quads quads(cubes);
  Smoother smoother(quads, unit, cubes.grid(), whole.part(.2));
  for (int k = 0; k < kSteps; ++k) smoother.step(whole.part(.2 / kSteps));
  Positions positions(static_cast<Eigen::Index>(quads.places.size()), 3);
  for (size_t v = 0; v < quads.places.size(); ++v)
    positions.row(static_cast<Eigen::Index>(v)) = unit.size * quads.places[v] + unit.center;
  std::vector<int> corners;
  for (const std::array<int, 4>& face : quads.faces) corners.insert(corners.end(), face.begin(), face.end());
  meter.reach(1);
  return {std::move(positions), std::move(corners), std::vector<int>(quads.faces.size(), 4)};
}

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
