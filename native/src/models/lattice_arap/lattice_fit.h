// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "arap/types.h"
#include "constraints/linear_rows.h"
#include "lattice/lattice.h"
#include "parallel/workers.h"
#include "sparse/sparse.h"

namespace arap {

/// Finds the control points of a lattice that bring its vertices to given places, as well as they can. First each
/// control point moves as rigidly as the vertices around it do; what that leaves is corrected by least squares, by the
/// smallest change in the norm of K.
class LatticeFit {
 public:
  /// @param lattice  must outlive this
  /// @param areas    (n,) of the surface at each vertex
  /// @param rest     (n, 3) of the vertices
  /// @param K        of the lattice's energy; must outlive this
  LatticeFit(const Lattice& lattice, const std::vector<double>& areas, const Positions& rest, const SparseMatrix& K);

  /// (n_control_points, 3), for the places of the vertices, (n, 3).
  [[nodiscard]] Positions fit(const Positions& points, const Workers& workers) const;

 private:
  /// Sums over vertices around a control point, with weights: of 1, of rest, of places, of place times rest.
  using Moments = std::vector<Eigen::Matrix<double, 16, 1>>;

  [[nodiscard]] Moments moments(const Positions& points) const;
  /// Gives a part of what is around each to it, until all have enough.
  void spread(Moments& moments) const;
  void correct(const Positions& points, const Workers& workers, Positions& control_points) const;

  const Lattice& lattice_;
  const SparseMatrix& K_;
  Positions rest_;            ///< of the samples
  std::vector<int> samples_;  ///< vertices; of a piece with very many not all
  Eigen::VectorXd weights_;   ///< of the samples
  RowMatrix rows_;            ///< phi of the samples
  Eigen::VectorXd diagonal_;  ///< of the matrix of least squares
};

}  // namespace arap
