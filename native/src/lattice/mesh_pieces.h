// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>
#include <vector>

#include "arap/mesh.h"
#include "lattice/cube_grid.h"
#include "lattice/inside_samples.h"
#include "parallel/meter.h"

namespace arap {

inline constexpr double kSamplesInCube = kSamplesAlong * kSamplesAlong * kSamplesAlong;

/// The pieces of all parts of a mesh (see CubePieces). Each connected part has cubes of its own, around its middle.
class MeshPieces {
 public:
  /// @param mesh         with faces
  /// @param cube_size    > 0
  /// @param most_hollow  a part without an inside that would have more pieces than this has none, as if it were loose
  /// Throws InvalidInput if they are too many.
  MeshPieces(const PolygonMesh& mesh, double cube_size, const MeterPart& meter = {},
             int most_hollow = std::numeric_limits<int>::max());

  [[nodiscard]] int size() const { return static_cast<int>(cubes_.size()); }
  [[nodiscard]] int part(int piece) const { return parts_[piece]; }
  [[nodiscard]] Eigen::RowVector3d lowest_corner(int piece) const { return grid(piece).corner(cube(piece)); }
  /// The share of its cube that is inside.
  [[nodiscard]] double inside(int piece) const { return std::popcount(samples_[piece]) / kSamplesInCube; }
  /// Whether any piece has an inside.
  [[nodiscard]] bool has_inside() const {
    return std::ranges::any_of(samples_, [](SampleBits bits) { return bits != 0; });
  }
  [[nodiscard]] int n_parts() const { return static_cast<int>(grids_.size()); }
  /// The cubes of a part.
  [[nodiscard]] const CubeGrid& grid_of(int part) const { return grids_[part]; }
  /// The piece of one part that has a point inside, to a quarter of a cube; -1: none has.
  [[nodiscard]] int around(const Eigen::RowVector3d& point, int part) const;
  /// Of each vertex of the mesh, -1: it is loose.
  [[nodiscard]] const std::vector<int>& piece_of_vertex() const { return piece_of_vertex_; }

  /// Points of each piece in a cubic pattern, so many along each axis and a cube's size apart, along z first. Pieces
  /// that hang together share those at the same places. Returns the number of each, (size() along^3,), in order of
  /// first use.
  [[nodiscard]] std::vector<int> shared_points(int along) const;

 private:
  [[nodiscard]] const CubeGrid& grid(int piece) const { return grids_[parts_[piece]]; }
  [[nodiscard]] CubeGrid::Cube cube(int piece) const { return grid(piece).cube(cubes_[piece]); }

  std::vector<CubeGrid> grids_;  ///< of each part
  std::vector<int> cubes_;       ///< of each piece, in its part's grid; ascending within a part
  std::vector<int> parts_;       ///< of each piece
  std::vector<int> first_{0};    ///< piece of each part, and the end
  std::vector<SampleBits> samples_;
  std::vector<std::pair<int, int>> beside_;  ///< pieces of cubes side by side that hang together
  std::vector<int> piece_of_vertex_;
};

}  // namespace arap
