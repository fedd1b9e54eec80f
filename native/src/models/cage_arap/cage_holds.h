// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "cages/cage_points.h"
#include "constraints/linear_rows.h"

namespace arap {

/// What constrained vertices of a mesh mean for the cage that carries them: sum_v omega_v |phi_v c - t_v|^2 with
/// omega_v = strength times area_v / area of a vertex of the cage, so that a region is held as firmly at every density
/// of the mesh. If the areas of a handle (connected vertices) sum to less, each vertex gets as much more that they do.
/// Of a handle this has a few rows that matter, the eigenvectors of its matrix: far fewer than vertices, and than
/// vertices of the cage.
class CageHolds {
 public:
  CageHolds() = default;
  /// @param points           of the vertices in faces; must outlive this
  /// @param point_of_vertex  (n,) -1 for loose vertices
  /// @param mesh             for its edges
  /// @param areas            (n,) of the surface at each vertex
  /// @param cage_area        of a vertex of the cage
  /// @param stiffness        mean diagonal of K
  /// @param set              with numbers of the mesh's vertices
  CageHolds(const CagePoints& points, const std::vector<int>& point_of_vertex, const PolygonMesh& mesh,
            const std::vector<double>& areas, double cage_area, double stiffness, const ConstraintSet& set);

  /// Rows over the vertices of the cage: those of handles, then one a patch.
  [[nodiscard]] const LinearRows& rows() const { return rows_; }
  /// The handle or patch that each row is of.
  [[nodiscard]] const std::vector<int>& handle_of_row() const { return handle_of_row_; }
  /// Their targets, (n_rows, 3), from those of the set.
  [[nodiscard]] Positions targets(const Positions& of_set) const;
  /// For each row a target of the set that it is about.
  [[nodiscard]] const std::vector<int>& sources() const { return sources_; }

 private:
  /// Rows of connected vertices, one after the other.
  struct Handle {
    std::vector<int> sources;  ///< rows of the set's targets
    std::vector<int> points;
    Eigen::VectorXd weights;  ///< omega
    Eigen::MatrixXd to_rows;  ///< (n_rows, n) of t, the rows' targets
  };

  void add_rows(Handle handle, double stiffness);
  void add_row(const Eigen::RowVectorXd& row, double weight, int source, int handle);

  const CagePoints* points_ = nullptr;
  LinearRows rows_;
  std::vector<int> handle_of_row_;
  std::vector<int> sources_;
  std::vector<Handle> handles_;
};

}  // namespace arap
