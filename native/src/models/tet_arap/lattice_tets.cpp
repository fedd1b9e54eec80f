// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/lattice_tets.h"

#include <algorithm>
#include <utility>

#include "arap/error.h"
#include "arap/lattice_arap.h"
#include "base/format_message.h"
#include "lattice/lattice.h"
#include "lattice/voids.h"
#include "mesh/surface_measures.h"
#include "models/input_checks.h"
#include "models/model_space.h"
#include "parallel/meter.h"

namespace arap {

namespace {

constexpr int kCorners = 8;
constexpr int kTetsOfCube = 6;

/// The orders of the axes. A tetrahedron goes along the edges from the lowest corner of a cube to the highest; so faces
/// of neighbouring cubes are cut alike. The last three are the odd ones: their last two corners are swapped.
constexpr std::array<std::array<int, 3>, kTetsOfCube> kPaths = {
    {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
bool is_odd(int path) { return path >= kTetsOfCube / 2; }

/// Corners are numbered along z first.
std::array<int, 4> corners_of(int path) {
  constexpr std::array<int, 3> kSteps = {4, 2, 1};
  std::array<int, 4> corners{};
  for (int k = 0; k < 3; ++k) corners[k + 1] = corners[k] + kSteps[kPaths[path][k]];
  if (is_odd(path)) std::swap(corners[2], corners[3]);
  return corners;
}

/// Which tetrahedron of a cube a point is in, and its barycentric coordinates.
/// @param place  in the cube, 0 to 1
std::pair<int, std::array<double, 4>> find_tet(const Eigen::RowVector3d& place) {
  const Eigen::RowVector3d x = place.cwiseMax(0).cwiseMin(1);
  const auto goes_down = [&](const std::array<int, 3>& path) {
    return x[path[0]] >= x[path[1]] && x[path[1]] >= x[path[2]];
  };
  const auto found = std::find_if(kPaths.begin(), kPaths.end(), goes_down);
  const std::array<int, 3>& path = *found;
  std::array<double, 4> coordinates{1 - x[path[0]], x[path[0]] - x[path[1]], x[path[1]] - x[path[2]], x[path[2]]};
  const auto number = static_cast<int>(found - kPaths.begin());
  if (is_odd(number)) std::swap(coordinates[2], coordinates[3]);
  return {number, coordinates};
}

}  // namespace

Patch LatticeTets::patch(int vertex) const {
  const auto n = static_cast<int>(tet_of_vertex.size());
  if (vertex < 0 || vertex >= n)
    throw InvalidInput(text("vertex ", vertex, " is not there, the surface has vertices 0 to ", n - 1));
  if (tet_of_vertex[vertex] < 0)
    throw InvalidInput(text("vertex ", vertex, " is in no face, so nothing can move it; leave it out"));
  const TetMesh::Tet& tet = mesh.tets()[tet_of_vertex[vertex]];
  Patch patch{{tet.begin(), tet.end()}, {coordinates[vertex].begin(), coordinates[vertex].end()}};
  for (int k = 0; k < 4; ++k) patch.rest_position += patch.weights[k] * mesh.positions().row(tet[k]).transpose();
  return patch;
}

void LatticeTets::embed(const Positions& of_tets, Positions& of_surface) const {
  require_rows("of_tets", of_tets.rows(), mesh.n_vertices());
  require_rows("of_surface", of_surface.rows(), static_cast<Eigen::Index>(tet_of_vertex.size()));
  for (Eigen::Index v = 0; v < of_surface.rows(); ++v) {
    if (tet_of_vertex[v] < 0) continue;
    const TetMesh::Tet& tet = mesh.tets()[tet_of_vertex[v]];
    // From one corner: far from the origin a sum of all loses digits.
    Eigen::RowVector3d shift = Eigen::RowVector3d::Zero();
    for (int k = 1; k < 4; ++k) shift += coordinates[v][k] * (of_tets.row(tet[k]) - of_tets.row(tet[0]));
    of_surface.row(v) = of_tets.row(tet[0]) + shift;
  }
}

LatticeTets LatticeTets::around(const PolygonMesh& surface, double cube_size, const Progress& progress) {
  LatticeOptions options;
  options.cube_size = cube_size;
  options.validate();
  require_surface(surface);
  const ModelSpace space(surface);
  const PolygonMesh model = join_voids(space.make_model(surface));
  Meter meter(progress, "cutting into tetrahedra was cancelled");
  const double size = choose_cube_size(model, cube_size, 1, {&meter, 0});
  const MeshPieces pieces(model, size, {&meter, 0.8});
  const std::vector<int> numbers = pieces.shared_points(2);
  Positions positions(1 + *std::max_element(numbers.begin(), numbers.end()), 3);
  std::vector<TetMesh::Tet> tets;
  tets.reserve(static_cast<size_t>(kTetsOfCube) * pieces.size());
  for (int piece = 0; piece < pieces.size(); ++piece) {
    const auto number = [&](int corner) { return numbers[kCorners * piece + corner]; };
    for (int k = 0; k < kCorners; ++k) {
      const CubeGrid::Cube steps{k / 4, k / 2 % 2, k % 2};
      positions.row(number(k)) = space.to_input(
          Eigen::RowVector3d(pieces.lowest_corner(piece) + size * Eigen::RowVector3d(steps[0], steps[1], steps[2])));
    }
    for (int path = 0; path < kTetsOfCube; ++path) {
      TetMesh::Tet tet = corners_of(path);
      for (int& corner : tet) corner = number(corner);
      tets.push_back(tet);
    }
  }
  LatticeTets result{TetMesh(std::move(positions), std::move(tets)), std::vector<int>(surface.n_vertices(), -1),
                     std::vector<std::array<double, 4>>(surface.n_vertices())};
  for (int v = 0; v < surface.n_vertices(); ++v) {
    const int piece = pieces.piece_of_vertex()[v];
    if (piece < 0) continue;
    const auto [tet, coordinates] = find_tet((model.positions().row(v) - pieces.lowest_corner(piece)) / size);
    result.tet_of_vertex[v] = kTetsOfCube * piece + tet;
    result.coordinates[v] = coordinates;
  }
  meter.reach(1);
  return result;
}

}  // namespace arap
