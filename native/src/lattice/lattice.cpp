// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "arap/error.h"
#include "base/eigen_compat.h"
#include "base/format_message.h"
#include "base/grouped.h"
#include "base/union_find.h"
#include "lattice/cube_pieces.h"
#include "mesh/polygon_ears.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

using Pair = std::pair<int, int>;
using Triangles = std::vector<std::array<int, 3>>;

/// More take more memory than the mesh that they are for could be worth.
constexpr int kMostPieces = 300'000;

}  // namespace

Lattice::Lattice(const PolygonMesh& mesh, double cube_size, const MeterPart& meter, int most_hollow)
    : cube_size_(cube_size),
      piece_of_vertex_(mesh.n_vertices(), -1),
      places_(mesh.n_vertices(), Eigen::Vector3f::Zero()) {
  const std::vector<int>& part_of = mesh.part_of_vertex();
  const Grouped vertices(mesh.n_parts(), [&](const auto& add) {
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (part_of[v] >= 0) add(part_of[v], v);
  });
  const Grouped faces(mesh.n_parts(), [&](const auto& add) {
    for (int f = 0; f < mesh.n_faces(); ++f) add(part_of[mesh.face(f)[0]], f);
  });
  std::vector<int> local(mesh.n_vertices(), -1);
  std::vector<Pair> beside;
  EarCutter ears;
  for (int part = 0; part < mesh.n_parts(); ++part) {
    const std::span<const int> own = vertices.of(part);
    Positions points(own.size(), 3);
    for (size_t k = 0; k < own.size(); ++k) {
      local[own[k]] = static_cast<int>(k);
      points.row(static_cast<Eigen::Index>(k)) = mesh.positions().row(own[k]);
    }
    Triangles triangles;
    for (const int f : faces.of(part)) ears.cut(mesh.positions(), mesh.face(f), triangles);
    for (std::array<int, 3>& triangle : triangles)
      for (int& v : triangle) v = local[v];
    const CubeGrid grid = grid_around(
        Eigen::AlignedBox3d(points.colwise().minCoeff().transpose(), points.colwise().maxCoeff().transpose()),
        cube_size_);
    const CubePieces pieces =
        find_pieces(points, triangles, grid, meter.part(static_cast<double>(own.size()) / mesh.n_vertices()));
    const bool is_hollow = std::ranges::all_of(pieces.samples, [](SampleBits bits) { return bits == 0; });
    if (is_hollow && pieces.size() > most_hollow)
      add_part(grid, {}, points, {}, beside);
    else
      add_part(grid, pieces, points, own, beside);
    if (n_pieces() > kMostPieces)
      throw InvalidInput(
          text("the mesh has more than ", kMostPieces, " pieces in cubes of ", cube_size,
               " of its size, which is the most that can be posed; join its seams or take larger cubes"));
  }
  name_control_points(beside);
}

void Lattice::add_part(const CubeGrid& grid, const CubePieces& pieces, const Positions& points,
                       std::span<const int> vertices, std::vector<Pair>& beside) {
  const int first = n_pieces();
  cubes_.insert(cubes_.end(), pieces.cubes.begin(), pieces.cubes.end());
  samples_.insert(samples_.end(), pieces.samples.begin(), pieces.samples.end());
  part_of_piece_.resize(cubes_.size(), n_parts());
  grids_.push_back(grid);
  first_pieces_.push_back(n_pieces());
  for (const auto& [a, b] : pieces.beside) beside.emplace_back(first + a, first + b);
  for (size_t k = 0; k < vertices.size(); ++k) {
    const int piece = pieces.piece_of_vertex[k];
    piece_of_vertex_[vertices[k]] = first + piece;
    const Eigen::RowVector3d corner = grid.corner(grid.cube(pieces.cubes[piece]));
    places_[vertices[k]] = ((points.row(static_cast<Eigen::Index>(k)) - corner) / grid.size).transpose().cast<float>();
  }
}

void Lattice::name_control_points(const std::vector<Pair>& beside) {
  UnionFind same(kControlPoints * n_pieces());
  for (const auto& [a, b] : beside) {
    const CubeGrid& grid = grids_[part_of_piece_[a]];
    const CubeGrid::Cube from = grid.cube(cubes_[a]);
    const CubeGrid::Cube to = grid.cube(cubes_[b]);
    for (int k = 0; k < kControlPoints; ++k) {
      const std::array<int, 3> seen{k / 9 + from[0] - to[0], k / 3 % 3 + from[1] - to[1], k % 3 + from[2] - to[2]};
      if (std::all_of(seen.begin(), seen.end(), [](int i) { return i >= 0 && i < 3; }))
        same.join(kControlPoints * a + k, kControlPoints * b + 9 * seen[0] + 3 * seen[1] + seen[2]);
    }
  }
  std::vector<int> number(static_cast<size_t>(kControlPoints) * cubes_.size(), -1);
  control_points_.resize(cubes_.size());
  std::vector<Eigen::RowVector3d> rest;
  for (int piece = 0; piece < n_pieces(); ++piece)
    for (int k = 0; k < kControlPoints; ++k) {
      int& of_set = number[same.find(kControlPoints * piece + k)];
      if (of_set < 0) {
        of_set = static_cast<int>(rest.size());
        const CubeGrid::Cube steps{k / 9, k / 3 % 3, k % 3};
        const CubeGrid& grid = grids_[part_of_piece_[piece]];
        rest.emplace_back(grid.corner(grid.cube(cubes_[piece])) +
                          grid.size * (Eigen::RowVector3d(steps[0], steps[1], steps[2]).array() - 0.5).matrix());
        parts_.push_back(part_of_piece_[piece]);
      }
      control_points_[piece][k] = of_set;
    }
  rest_.resize(static_cast<Eigen::Index>(rest.size()), 3);
  for (size_t c = 0; c < rest.size(); ++c) rest_.row(static_cast<Eigen::Index>(c)) = rest[c];
}

std::span<const int> Lattice::cubes_of(int part) const {
  const std::span<const int> cubes(cubes_);
  return cubes.subspan(first_pieces_[part], first_pieces_[part + 1] - first_pieces_[part]);
}

int Lattice::piece_around(const Eigen::RowVector3d& point, int part) const {
  const CubeGrid& grid = grids_[part];
  const Eigen::RowVector3d place = (point - grid.origin) / grid.size;
  std::array<int, 3> sample{};
  for (int k = 0; k < 3; ++k) {
    if (!(place[k] >= 0 && place[k] < grid.counts[k])) return -1;
    sample[k] = static_cast<int>(kSamplesAlong * place[k]);
  }
  const auto [begin, end] = std::ranges::equal_range(cubes_of(part), grid.index(cube_of(sample)));
  const auto first = static_cast<int>(begin - cubes_of(part).begin()) + first_pieces_[part];
  for (int piece = first; piece < first + static_cast<int>(end - begin); ++piece)
    if ((samples_[piece] >> bit_of(sample) & 1) != 0) return piece;
  return -1;
}

Lattice::AxisWeights Lattice::axis_weights(const Eigen::Vector3d& place) {
  return {spline_weights(place[0]), spline_weights(place[1]), spline_weights(place[2])};
}

Lattice::Weights Lattice::weights(int vertex) const { return weights_at(places_[vertex].cast<double>()); }

Lattice::Weights Lattice::weights_at(const Eigen::Vector3d& place) {
  const auto [x, y, z] = axis_weights(place);
  Weights result;
  double* next = result.data();
  for (const double of_x : x)
    for (const double of_y : y)
      for (const double of_z : z) *next++ = of_x * of_y * of_z;
  return result;
}

LinearRow Lattice::row(int vertex) const {
  const ControlPoints& points = control_points_[piece_of_vertex_[vertex]];
  const auto phi = weights(vertex);
  return {{points.begin(), points.end()}, {phi.begin(), phi.end()}};
}

Positions Lattice::corners(const Positions& control_points) const {
  constexpr int kCorners = 8;
  Eigen::Matrix<double, kCorners, kControlPoints> weights;
  for (int k = 0; k < kCorners; ++k)
    weights.row(k) = weights_at(Eigen::Vector3d(k >> 2, k >> 1 & 1, k & 1)).transpose();
  Positions result(Eigen::Index{kCorners} * n_pieces(), 3);
  for (int piece = 0; piece < n_pieces(); ++piece)
    result.middleRows<kCorners>(Eigen::Index{kCorners} * piece) = weights * control_points(control_points_[piece], all);
  return result;
}

void Lattice::renumber(const std::vector<int>& new_of_old) {
  Positions rest(rest_.rows(), 3);
  std::vector<int> parts(parts_.size());
  for (size_t c = 0; c < parts_.size(); ++c) {
    rest.row(new_of_old[c]) = rest_.row(static_cast<Eigen::Index>(c));
    parts[new_of_old[c]] = parts_[c];
  }
  rest_ = std::move(rest);
  parts_ = std::move(parts);
  for (ControlPoints& points : control_points_)
    for (int& c : points) c = new_of_old[c];
}

void Lattice::embed(const Positions& control_points, const Workers& workers, Positions& points) const {
  const auto n = static_cast<int>(piece_of_vertex_.size());
  parallel_for<1024>(workers, n, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      if (piece_of_vertex_[v] < 0) continue;
      const ControlPoints& of_piece = control_points_[piece_of_vertex_[v]];
      const auto [x, y, z] = axis_weights(places_[v].cast<double>());
      const int* c = of_piece.data();
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (const double of_x : x) {
        Eigen::RowVector3d along_y = Eigen::RowVector3d::Zero();
        for (const double of_y : y) {
          along_y += of_y * (z[0] * control_points.row(c[0]) + z[1] * control_points.row(c[1]) +
                             z[2] * control_points.row(c[2]));
          c += 3;
        }
        sum += of_x * along_y;
      }
      points.row(v) = sum;
    }
  });
}

}  // namespace arap
