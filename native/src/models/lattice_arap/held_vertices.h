// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "constraints/linear_rows.h"
#include "lattice/lattice.h"

namespace arap {

/// What constrained vertices mean for a lattice: sum_v omega_v |phi_v c - t_v|^2 with omega_v = strength times area_v /
/// cube size, so that a region is held as firmly at every density of the mesh. Of the vertices in a piece this has at
/// most 27 independent rows, the eigenvectors of its matrix: as many as they are few, or as the piece has control
/// points.
class HeldVertices {
 public:
  HeldVertices() = default;
  /// @param areas  (n,) of the surface at each vertex
  /// @param set    with numbers of the mesh's vertices
  HeldVertices(const Lattice& lattice, const std::vector<double>& areas, const ConstraintSet& set);

  /// Rows over control points: those of vertices, then one a patch.
  [[nodiscard]] const LinearRows& rows() const { return rows_; }
  /// Their targets, (n_rows, 3), from those of the set.
  [[nodiscard]] Positions targets(const Positions& of_set) const { return from_set_ * of_set; }
  /// For each row a target of the set that it is about.
  [[nodiscard]] const std::vector<int>& sources() const { return sources_; }

 private:
  LinearRows rows_;
  Eigen::SparseMatrix<double, Eigen::RowMajor, int> from_set_;
  std::vector<int> sources_;
};

/// Hard vertices are exactly at their targets: what the lattice leaves is spread around them.
class ExactVertices {
 public:
  ExactVertices() = default;
  /// @param reach  along edges; from there on nothing moves
  ExactVertices(const PolygonMesh& mesh, const ConstraintSet& set, double reach);

  /// @param targets  of the set
  void apply(const Positions& targets, Positions& points) const;

 private:
  struct Held {
    int vertex;
    std::vector<int> targets;  ///< rows; it takes their mean
  };
  struct Follower {
    int vertex;
    int held;  ///< the nearest one
    double share;
  };
  std::vector<Held> held_;
  std::vector<Follower> followers_;
};

}  // namespace arap
