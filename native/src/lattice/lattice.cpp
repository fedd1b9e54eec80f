// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "base/grouped.h"
#include "base/union_find.h"
#include "lattice/cube_pieces.h"
#include "mesh/surface_measures.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

using Pair = std::pair<int, int>;
using Triangles = std::vector<std::array<int, 3>>;

/// An odd number of cubes along each axis: the middle of the box is the middle of a cube. So mirror planes through it
/// pass between the samples.
CubeGrid make_grid(const Eigen::AlignedBox3d& box, double cube_size) {
  CubeGrid grid;
  grid.size = cube_size;
  for (int k = 0; k < 3; ++k) {
    const auto n = static_cast<int>(std::ceil(box.sizes()[k] / cube_size + 1e-6));
    grid.counts[k] = n + 1 - n % 2;
    grid.origin[k] = box.center()[k] - 0.5 * grid.counts[k] * cube_size;
  }
  return grid;
}

}  // namespace

Lattice::Lattice(const PolygonMesh& mesh, double cube_size, const MeterPart& meter)
    : grid_(make_grid(surface_box(mesh), cube_size)),
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
  std::vector<int> cubes;
  std::vector<int> part_of_piece;
  for (int part = 0; part < mesh.n_parts(); ++part) {
    const std::span<const int> own = vertices.of(part);
    Positions points(own.size(), 3);
    for (size_t k = 0; k < own.size(); ++k) {
      local[own[k]] = static_cast<int>(k);
      points.row(static_cast<Eigen::Index>(k)) = mesh.positions().row(own[k]);
    }
    Triangles triangles;
    for (const int f : faces.of(part)) {
      const std::span<const int> face = mesh.face(f);
      for (size_t k = 2; k < face.size(); ++k)
        triangles.push_back({local[face[0]], local[face[k - 1]], local[face[k]]});
    }
    add_part(part, points, triangles, own, beside, cubes, part_of_piece);
    meter.add(static_cast<double>(own.size()) / mesh.n_vertices());
  }
  constexpr int kMostPieces = 300'000;
  if (n_pieces() > kMostPieces)
    throw InvalidInput(text("the mesh has ", n_pieces(), " pieces in cubes of ", cube_size, " of its size, at most ",
                            kMostPieces, " can be posed; join its seams or take larger cubes"));
  name_control_points(cubes, beside, part_of_piece);
}

void Lattice::add_part(int part, const Positions& points, const Triangles& triangles, std::span<const int> vertices,
                       std::vector<Pair>& beside, std::vector<int>& cubes, std::vector<int>& part_of_piece) {
  const CubePieces pieces = find_pieces(points, triangles, grid_);
  const int first = n_pieces();
  inside_.insert(inside_.end(), pieces.inside.begin(), pieces.inside.end());
  cubes.insert(cubes.end(), pieces.cubes.begin(), pieces.cubes.end());
  part_of_piece.resize(cubes.size(), part);
  for (const auto& [a, b] : pieces.beside) beside.emplace_back(first + a, first + b);
  for (size_t k = 0; k < vertices.size(); ++k) {
    const int piece = first + pieces.piece_of_vertex[k];
    piece_of_vertex_[vertices[k]] = piece;
    const Eigen::RowVector3d corner = grid_.corner(grid_.cube(cubes[piece]));
    places_[vertices[k]] = ((points.row(static_cast<Eigen::Index>(k)) - corner) / grid_.size).transpose().cast<float>();
  }
}

void Lattice::name_control_points(const std::vector<int>& cubes, const std::vector<Pair>& beside,
                                  const std::vector<int>& part_of_piece) {
  UnionFind same(kControlPoints * n_pieces());
  for (const auto& [a, b] : beside) {
    const CubeGrid::Cube from = grid_.cube(cubes[a]);
    const CubeGrid::Cube to = grid_.cube(cubes[b]);
    for (int k = 0; k < kControlPoints; ++k) {
      const std::array<int, 3> seen{k / 9 + from[0] - to[0], k / 3 % 3 + from[1] - to[1], k % 3 + from[2] - to[2]};
      if (std::all_of(seen.begin(), seen.end(), [](int i) { return i >= 0 && i < 3; }))
        same.join(kControlPoints * a + k, kControlPoints * b + 9 * seen[0] + 3 * seen[1] + seen[2]);
    }
  }
  std::vector<int> number(static_cast<size_t>(kControlPoints) * inside_.size(), -1);
  control_points_.resize(inside_.size());
  std::vector<Eigen::RowVector3d> rest;
  for (int piece = 0; piece < n_pieces(); ++piece)
    for (int k = 0; k < kControlPoints; ++k) {
      int& of_set = number[same.find(kControlPoints * piece + k)];
      if (of_set < 0) {
        of_set = static_cast<int>(rest.size());
        const CubeGrid::Cube steps{k / 9, k / 3 % 3, k % 3};
        rest.emplace_back(grid_.corner(grid_.cube(cubes[piece])) +
                          grid_.size * (Eigen::RowVector3d(steps[0], steps[1], steps[2]).array() - 0.5).matrix());
        parts_.push_back(part_of_piece[piece]);
      }
      control_points_[piece][k] = of_set;
    }
  rest_.resize(static_cast<Eigen::Index>(rest.size()), 3);
  for (size_t c = 0; c < rest.size(); ++c) rest_.row(static_cast<Eigen::Index>(c)) = rest[c];
}

Eigen::Matrix<double, kControlPoints, 1> Lattice::weights(int vertex) const {
  const Eigen::Vector3d place = places_[vertex].cast<double>();
  const auto x = spline_weights(place[0]);
  const auto y = spline_weights(place[1]);
  const auto z = spline_weights(place[2]);
  Eigen::Matrix<double, kControlPoints, 1> result;
  for (int k = 0; k < kControlPoints; ++k) result[k] = x[k / 9] * y[k / 3 % 3] * z[k % 3];
  return result;
}

LinearRow Lattice::row(int vertex) const {
  const ControlPoints& points = control_points_[piece_of_vertex_[vertex]];
  const auto phi = weights(vertex);
  return {{points.begin(), points.end()}, {phi.begin(), phi.end()}};
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
      const auto phi = weights(v);
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (int k = 0; k < kControlPoints; ++k) sum += phi[k] * control_points.row(of_piece[k]);
      points.row(v) = sum;
    }
  });
}

}  // namespace arap
