// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/mesh_pieces.h"

#include <algorithm>
#include <array>
#include <span>

#include "arap/error.h"
#include "base/format_message.h"
#include "base/grouped.h"
#include "base/union_find.h"
#include "lattice/cube_pieces.h"
#include "mesh/polygon_ears.h"

namespace arap {

namespace {

/// More take more memory than the mesh that they are for could be worth.
constexpr int kMostPieces = 300'000;

}  // namespace

MeshPieces::MeshPieces(const PolygonMesh& mesh, double cube_size, const MeterPart& meter, int most_hollow)
    : piece_of_vertex_(mesh.n_vertices(), -1) {
  const std::vector<int>& part_of = mesh.part_of_vertex();
  const Grouped vertices(mesh.n_parts(), [&](const auto& add) {
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (part_of[v] >= 0) add(part_of[v], v);
  });
  const Grouped faces(mesh.n_parts(), [&](const auto& add) {
    for (int f = 0; f < mesh.n_faces(); ++f) add(part_of[mesh.face(f)[0]], f);
  });
  std::vector<int> local(mesh.n_vertices(), -1);
  EarCutter ears;
  for (int part = 0; part < mesh.n_parts(); ++part) {
    const std::span<const int> own = vertices.of(part);
    Positions points(own.size(), 3);
    for (size_t k = 0; k < own.size(); ++k) {
      local[own[k]] = static_cast<int>(k);
      points.row(static_cast<Eigen::Index>(k)) = mesh.positions().row(own[k]);
    }
    std::vector<std::array<int, 3>> triangles;
    for (const int f : faces.of(part)) ears.cut(mesh.positions(), mesh.face(f), triangles);
    for (std::array<int, 3>& triangle : triangles)
      for (int& v : triangle) v = local[v];
    grids_.push_back(grid_around(
        Eigen::AlignedBox3d(points.colwise().minCoeff().transpose(), points.colwise().maxCoeff().transpose()),
        cube_size));
    const CubePieces pieces =
        find_pieces(points, triangles, grids_.back(), meter.part(static_cast<double>(own.size()) / mesh.n_vertices()));
    const bool is_hollow = std::ranges::all_of(pieces.samples, [](SampleBits bits) { return bits == 0; });
    if (is_hollow && pieces.size() > most_hollow) {
      first_.push_back(size());
      continue;
    }
    const int first = size();
    samples_.insert(samples_.end(), pieces.samples.begin(), pieces.samples.end());
    cubes_.insert(cubes_.end(), pieces.cubes.begin(), pieces.cubes.end());
    parts_.resize(cubes_.size(), part);
    first_.push_back(size());
    for (const auto& [a, b] : pieces.beside) beside_.emplace_back(first + a, first + b);
    for (size_t k = 0; k < own.size(); ++k) piece_of_vertex_[own[k]] = first + pieces.piece_of_vertex[k];
    if (size() > kMostPieces)
      throw InvalidInput(
          text("the mesh has more than ", kMostPieces, " pieces in cubes of ", cube_size,
               " of its size, which is the most that can be posed; join its seams or take larger cubes"));
  }
}

int MeshPieces::around(const Eigen::RowVector3d& point, int part) const {
  const CubeGrid& grid = grids_[part];
  const Eigen::RowVector3d place = (point - grid.origin) / grid.size;
  std::array<int, 3> sample{};
  for (int k = 0; k < 3; ++k) {
    if (!(place[k] >= 0 && place[k] < grid.counts[k])) return -1;
    sample[k] = static_cast<int>(kSamplesAlong * place[k]);
  }
  const auto cubes = std::span(cubes_).subspan(first_[part], first_[part + 1] - first_[part]);
  const auto [begin, end] = std::equal_range(cubes.begin(), cubes.end(), grid.index(cube_of(sample)));
  for (auto found = begin; found != end; ++found) {
    const int piece = first_[part] + static_cast<int>(found - cubes.begin());
    if ((samples_[piece] >> bit_of(sample) & 1) != 0) return piece;
  }
  return -1;
}

std::vector<int> MeshPieces::shared_points(int along) const {
  const int of_piece = along * along * along;
  const auto place = [&](int k) { return std::array<int, 3>{k / (along * along), k / along % along, k % along}; };
  UnionFind same(of_piece * size());
  for (const auto& [a, b] : beside_) {
    const CubeGrid::Cube from = cube(a);
    const CubeGrid::Cube to = cube(b);
    for (int k = 0; k < of_piece; ++k) {
      std::array<int, 3> seen = place(k);
      for (int axis = 0; axis < 3; ++axis) seen[axis] += from[axis] - to[axis];
      if (std::all_of(seen.begin(), seen.end(), [&](int i) { return i >= 0 && i < along; }))
        same.join(of_piece * a + k, of_piece * b + (seen[0] * along + seen[1]) * along + seen[2]);
    }
  }
  std::vector<int> numbers(same.size(), -1);
  int n_points = 0;
  for (int k = 0; k < same.size(); ++k) {
    // The lowest of a set comes first.
    const int first = same.find(k);
    numbers[k] = first == k ? n_points++ : numbers[first];
  }
  return numbers;
}

}  // namespace arap
