// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "arap/mesh.h"
#include "lattice/cube_grid.h"
#include "parallel/meter.h"

namespace arap {

/// The pieces of all parts of a mesh (see CubePieces). Each connected part has cubes of its own, around its middle.
class MeshPieces {
 public:
  /// @param mesh       with faces
  /// @param cube_size  > 0
  /// Throws InvalidInput if they are too many.
  MeshPieces(const PolygonMesh& mesh, double cube_size, const MeterPart& meter = {});

  [[nodiscard]] int size() const { return static_cast<int>(cubes_.size()); }
  [[nodiscard]] int part(int piece) const { return parts_[piece]; }
  [[nodiscard]] Eigen::RowVector3d lowest_corner(int piece) const { return grid(piece).corner(cube(piece)); }
  /// Of each piece, the share of its cube that is inside.
  [[nodiscard]] const std::vector<double>& inside() const { return inside_; }
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
  std::vector<int> cubes_;       ///< of each piece, in its part's grid
  std::vector<int> parts_;       ///< of each piece
  std::vector<double> inside_;
  std::vector<std::pair<int, int>> beside_;  ///< pieces of cubes side by side that hang together
  std::vector<int> piece_of_vertex_;
};

}  // namespace arap
