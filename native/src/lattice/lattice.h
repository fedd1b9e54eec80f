// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "arap/mesh.h"
#include "constraints/linear_rows.h"
#include "energy/cube_cells.h"
#include "kernels/isa.h"
#include "lattice/mesh_pieces.h"
#include "lattice/spline.h"
#include "parallel/meter.h"
#include "parallel/workers.h"

namespace arap {

/// A sparse lattice around a mesh: the cubes that its surface touches or fills, in pieces (see MeshPieces), and on them
/// quadratic B-splines. A point x of a piece is sum_k phi_k(x) c_k over the piece's 27 control points: C1 from cube to
/// cube, and affine maps of the control points are met exactly. A part of the mesh that is smaller than a cube has 27
/// control points.
class Lattice {
 public:
  using ControlPoints = CubeCells::ControlPoints;
  using Weights = Eigen::Matrix<double, kControlPoints, 1>;

  /// @param mesh         with faces; a loose vertex is in no piece
  /// @param cube_size    > 0
  /// @param most_hollow  a part without an inside that would have more pieces than this has none, as if it were loose
  Lattice(const PolygonMesh& mesh, double cube_size, const MeterPart& meter = {},
          int most_hollow = std::numeric_limits<int>::max());

  [[nodiscard]] double cube_size() const { return cube_size_; }
  [[nodiscard]] int n_pieces() const { return pieces_.size(); }
  [[nodiscard]] int n_control_points() const { return static_cast<int>(rest_.rows()); }

  /// (n_control_points, 3)
  [[nodiscard]] const Positions& rest() const { return rest_; }
  [[nodiscard]] const std::vector<int>& part_of_control_point() const { return parts_; }
  [[nodiscard]] const ControlPoints& control_points(int piece) const { return control_points_[piece]; }
  [[nodiscard]] const std::vector<ControlPoints>& control_points() const { return control_points_; }
  [[nodiscard]] const MeshPieces& pieces() const { return pieces_; }
  /// Of each vertex, -1: it is loose.
  [[nodiscard]] const std::vector<int>& piece_of_vertex() const { return pieces_.piece_of_vertex(); }

  /// phi of a vertex that is in a piece, by number of control point.
  [[nodiscard]] Weights weights(int vertex) const;
  /// phi of a place in a cube, each coordinate in [0, 1].
  [[nodiscard]] static Weights weights_at(const Eigen::Vector3d& place);
  /// The same of a vertex as a row over all control points.
  [[nodiscard]] LinearRow row(int vertex) const;

  /// (8 n_pieces, 3) the corners of each piece's cube, by number 4 x + 2 y + z.
  /// @param control_points  (n_control_points, 3)
  [[nodiscard]] Positions corners(const Positions& control_points) const;

  /// Numbers the control points anew.
  void renumber(const std::vector<int>& new_of_old);

  /// Writes the rows of all vertices but loose ones.
  /// @param control_points  (n_control_points, 3)
  void embed(const Positions& control_points, const Workers& workers, Positions& points) const;

 private:
  /// Of the three control points along each axis.
  using AxisWeights = std::array<std::array<double, 3>, 3>;

  [[nodiscard]] static AxisWeights axis_weights(const Eigen::Vector3d& place);

  void name_control_points();

  double cube_size_;
  Isa isa_ = choose_isa();
  MeshPieces pieces_;
  std::vector<ControlPoints> control_points_;
  std::vector<int> parts_;
  Positions rest_;
  std::vector<Eigen::Vector3f> places_;  ///< of each vertex in its cube, 0 to 1
};

/// The size of cubes for a mesh of diagonal 1. By itself: four across a limb of the median thickness, a fiftieth at the
/// most, and so large that the cubes that are crossed or inside are 25,000 at the most, or two a part. It depends on
/// the shape alone, not on how finely it is meshed. Pieces of one cube are not counted.
/// @param wanted  0: none; otherwise the result, but for a ten-thousandth. Throws InvalidInput if cubes of this size
/// are too many.
[[nodiscard]] double choose_cube_size(const PolygonMesh& mesh, double wanted, int threads, const MeterPart& meter = {});

}  // namespace arap
