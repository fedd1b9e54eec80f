// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/voids.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/grouped.h"
#include "geometry/point_tree.h"
#include "geometry/triangle_grid.h"
#include "mesh/surface_measures.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// A part of a mesh.
struct Shell {
  double volume = 0;  ///< < 0: it is turned inside out
  double area = 0;
  Row opening = Row::Zero();  ///< sum of its vector areas: 0 if it is closed, and of some that are not
  Row origin = Row::Zero();
  Eigen::AlignedBox3d box;

  [[nodiscard]] bool may_be_closed() const {
    constexpr double kRounding = 1e-9;
    return volume != 0 && opening.norm() <= kRounding * area;
  }
  [[nodiscard]] bool is_smaller(const Shell& other) const { return std::abs(volume) < std::abs(other.volume); }
  [[nodiscard]] bool may_be_in(const Shell& other) const {
    return other.may_be_closed() && is_smaller(other) && other.box.contains(box);
  }
};

std::vector<Shell> find_shells(const PolygonMesh& mesh) {
  std::vector<Shell> shells(mesh.n_parts());
  const Positions& p = mesh.positions();
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    Shell& shell = shells[mesh.part_of_vertex()[face[0]]];
    if (shell.box.isEmpty()) shell.origin = p.row(face[0]);
    for (const int v : face) shell.box.extend(p.row(v).transpose());
    const Row doubled = twice_vector_area(p, face);
    shell.opening += doubled;
    shell.area += doubled.norm();
    shell.volume += doubled.dot(p.row(face[0]) - shell.origin) / 6;
  }
  return shells;
}

/// The parts that may be voids, by what costs little, the largest first.
std::vector<int> candidates_of(const std::vector<Shell>& shells) {
  std::array<std::vector<int>, 2> sides;
  for (size_t part = 0; part < shells.size(); ++part)
    if (shells[part].may_be_closed()) sides[shells[part].volume < 0 ? 1 : 0].push_back(static_cast<int>(part));
  std::vector<int> candidates;
  for (const int side : {0, 1})
    for (const int inner : sides[side])
      if (std::ranges::any_of(sides[1 - side], [&](int outer) { return shells[inner].may_be_in(shells[outer]); }))
        candidates.push_back(inner);
  std::ranges::sort(candidates, [&](int a, int b) { return shells[b].is_smaller(shells[a]); });
  return candidates;
}

/// Finds the shell that a void is in.
class VoidFinder {
 public:
  VoidFinder(const PolygonMesh& mesh, const std::vector<Shell>& shells)
      : mesh_(mesh),
        shells_(shells),
        vertices_(mesh.n_parts(),
                  [&](const auto& add) {
                    for (int v = 0; v < mesh.n_vertices(); ++v)
                      if (const int part = mesh.part_of_vertex()[v]; part >= 0) add(part, v);
                  }),
        faces_(mesh.n_parts(),
               [&](const auto& add) {
                 for (int f = 0; f < mesh.n_faces(); ++f) add(mesh.part_of_vertex()[mesh.face(f)[0]], f);
               }),
        grid_(mesh.positions(), triangles_of(mesh), kCell, 1) {
    for (int part = 0; part < mesh.n_parts(); ++part)
      is_closed_.push_back(shells[part].may_be_closed() && is_closed(part) ? 1 : 0);
  }

  /// The smallest closed part that a part is inside of; -1: there is none, or it is open.
  [[nodiscard]] int shell_around(int inner) const {
    int smallest = -1;
    if (is_closed_[inner] == 0) return smallest;
    for (int outer = 0; outer < mesh_.n_parts(); ++outer)
      if (is_closed_[outer] != 0 && shells_[inner].may_be_in(shells_[outer]) &&
          (smallest < 0 || shells_[outer].is_smaller(shells_[smallest])) && is_in(inner, outer))
        smallest = outer;
    return smallest;
  }

  /// Calls visit(a, b) for each vertex b of a part, with the nearest vertex of another one.
  template <class Visit>
  void for_each_nearest(int from, int to, const Visit& visit) {
    const PointTree& tree = tree_of(to);
    std::vector<PointTree::Near> found;
    for (const int v : vertices_.of(from)) {
      tree.nearest(mesh_.positions().row(v), 1, found);
      visit(vertices_.of(to)[found[0].point], v);
    }
  }

 private:
  static constexpr double kCell = .02;

  static std::vector<TriangleGrid::Triangle> triangles_of(const PolygonMesh& mesh) {
    std::vector<TriangleGrid::Triangle> result;
    for (int f = 0; f < mesh.n_faces(); ++f)
      for_each_in_fan(mesh.face(f), [&](int i, int j, int k) { result.push_back({i, j, k}); });
    return result;
  }

  /// The vertices of a part, made when first needed: a shell may have many voids.
  struct Tree {
    explicit Tree(Positions places_of_part) : places(std::move(places_of_part)), tree(places) {}
    Positions places;
    PointTree tree;
  };

  [[nodiscard]] const PointTree& tree_of(int part) {
    std::unique_ptr<Tree>& tree = trees_[part];
    if (tree == nullptr) {
      const std::span<const int> own = vertices_.of(part);
      Positions places(std::ssize(own), 3);
      for (std::ptrdiff_t k = 0; k < places.rows(); ++k) places.row(k) = mesh_.positions().row(own[k]);
      tree = std::make_unique<Tree>(std::move(places));
    }
    return tree->tree;
  }

  /// Whether faces run along each edge as often one way as the other.
  [[nodiscard]] bool is_closed(int part) const {
    std::map<std::pair<int, int>, int> ways;
    for (const int f : faces_.of(part)) {
      int from = mesh_.face(f).back();
      for (const int to : mesh_.face(f)) {
        ways[std::minmax(from, to)] += from < to ? 1 : -1;
        from = to;
      }
    }
    return std::ranges::all_of(ways, [](const auto& edge) { return edge.second == 0; });
  }

  [[nodiscard]] bool is_in(int inner, int outer) const {
    constexpr size_t kLooks = 8;
    const std::span<const int> own = vertices_.of(inner);
    const auto is_met = [&](const TriangleGrid::Triangle& t) { return mesh_.part_of_vertex()[t[0]] == outer; };
    for (size_t k = 0; k < own.size(); k += own.size() / kLooks + 1)
      if (grid_.winding(mesh_.positions().row(own[k]), 0, 1, 1, is_met) == 0) return false;
    return true;
  }

  const PolygonMesh& mesh_;
  const std::vector<Shell>& shells_;
  Grouped vertices_;  ///< of each part
  Grouped faces_;
  TriangleGrid grid_;
  std::vector<char> is_closed_;  ///< each part
  std::map<int, std::unique_ptr<Tree>> trees_;
};

}  // namespace

PolygonMesh join_voids(PolygonMesh mesh) {
  const std::vector<Shell> shells = find_shells(mesh);
  const std::vector<int> candidates = candidates_of(shells);
  if (candidates.empty()) return mesh;
  VoidFinder finder(mesh, shells);
  std::vector<int> corners;
  std::vector<int> sizes;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    corners.insert(corners.end(), mesh.face(f).begin(), mesh.face(f).end());
    sizes.push_back(static_cast<int>(mesh.face(f).size()));
  }
  std::vector<char> is_void(shells.size(), 0);
  for (const int inner : candidates) {
    const int outer = finder.shell_around(inner);
    if (outer < 0 || is_void[outer] != 0 || (shells[inner].volume < 0) == (shells[outer].volume < 0)) continue;
    is_void[inner] = 1;
    finder.for_each_nearest(inner, outer, [&](int a, int b) {
      corners.insert(corners.end(), {a, b, b});
      sizes.push_back(3);
    });
  }
  return {mesh.positions(), std::move(corners), std::move(sizes)};
}

}  // namespace arap
