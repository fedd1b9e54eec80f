// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "constraints/linear_rows.h"
#include "lattice/lattice.h"

namespace arap {

/// Strength of what is hard: what it leaves is a thousandth of the diagonal at the most, and the system stays easy.
inline constexpr double kHardStrength = 100;

/// What constrained vertices mean for a lattice: sum_v omega_v |phi_v c - t_v|^2 with omega_v = strength times area_v /
/// cube size, so that a region is held as firmly at every density of the mesh. If the areas in a piece sum to less than
/// the side of a cube, each vertex gets as much more that they do: a single one holds as a small region does. Of the
/// vertices in a piece this has at most 27 independent rows, the eigenvectors of its matrix: as many as they are few,
/// or as the piece has control points.
class HeldVertices {
 public:
  HeldVertices() = default;
  /// @param lattice  must outlive this
  /// @param areas    (n,) of the surface at each vertex
  /// @param set      with numbers of the mesh's vertices
  HeldVertices(const Lattice& lattice, const std::vector<double>& areas, const ConstraintSet& set);

  /// Rows over control points: those of vertices, then one a patch.
  [[nodiscard]] const LinearRows& rows() const { return rows_; }
  /// Their targets, (n_rows, 3), from those of the set.
  [[nodiscard]] Positions targets(const Positions& of_set) const;
  /// For each row a target of the set that it is about.
  [[nodiscard]] const std::vector<int>& sources() const { return sources_; }

 private:
  using Matrix27 = Eigen::Matrix<double, kControlPoints, kControlPoints>;

  struct Held {
    int source;  ///< row of the set's targets
    int vertex;
    double weight;  ///< omega
  };
  /// Rows of a piece, one after the other.
  struct Piece {
    std::vector<Held> held;
    Eigen::MatrixXd to_rows;  ///< (n_rows, 27) of sum_v omega_v phi_v t_v, the rows' targets
  };

  void add_rows(int piece, const Matrix27& normal, std::vector<Held> held);
  void add_patch(const ConstraintSet& set, int p);

  const Lattice* lattice_ = nullptr;
  LinearRows rows_;
  std::vector<Piece> pieces_;
  std::vector<int> sources_;
};

}  // namespace arap
