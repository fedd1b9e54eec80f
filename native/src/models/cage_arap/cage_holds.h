// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "cages/cage_points.h"
#include "constraints/linear_rows.h"
#include "parallel/meter.h"

namespace arap {

/// What constrained vertices of a mesh mean for the cage that carries them: sum_v omega_v |phi_v c - t_v|^2 with
/// omega_v = strength times area_v / area of a vertex of the cage, so that a region is held as firmly at every density
/// of the mesh. If the areas of a handle (connected vertices) sum to less, each vertex gets as much more that they do.
/// Of a handle this has a few rows that matter, far fewer than vertices, and than vertices of the cage: its mean, and
/// those of a thin Cholesky factor of how its vertices differ from that. So a handle that is tiny beside the cage has
/// rows of its turn, too.
class CageHolds {
 public:
  CageHolds() = default;
  /// @param points           of the vertices in faces; it and the cage must outlive this
  /// @param point_of_vertex  (n,) -1 for loose vertices
  /// @param mesh             for its edges
  /// @param areas            (n,) of the surface at each vertex
  /// @param cage             at rest
  /// @param stiffness        mean diagonal of K
  /// @param set              with numbers of the mesh's vertices
  /// Throws Cancelled, or NotEnoughMemory.
  CageHolds(const CagePoints& points, const std::vector<int>& point_of_vertex, const PolygonMesh& mesh,
            const std::vector<double>& areas, const PolygonMesh& cage, double stiffness, const ConstraintSet& set,
            const MeterPart& meter);

  /// Rows over the vertices of the cage: those of handles, then one a patch, then the vertices of shells (connected
  /// parts of the cage) that stay: those that no constrained vertex feels, and those of parts of the mesh without
  /// constraints, if no constrained vertex is mostly theirs.
  [[nodiscard]] const LinearRows& rows() const { return rows_; }
  /// The handle, patch or shell that each row is of.
  [[nodiscard]] const std::vector<int>& handle_of_row() const { return handle_of_row_; }
  /// Their targets, (n_rows, 3), from those of the set.
  [[nodiscard]] Positions targets(const Positions& of_set) const;
  /// For each row a target of the set that it is about; -1: it stays.
  [[nodiscard]] const std::vector<int>& sources() const { return sources_; }
  /// Parts of the mesh in shells that stay, ascending.
  [[nodiscard]] const std::vector<int>& parts_at_rest() const { return parts_at_rest_; }

 private:
  /// Connected vertices, whose rows are one after the other: first their mean.
  struct Handle {
    std::vector<int> sources;  ///< rows of the set's targets
    std::vector<int> points;
    Eigen::VectorXd weights;   ///< omega
    std::vector<int> pivots;   ///< vertices of the cage: what is pulled at them tells the targets of the other rows
    Eigen::MatrixXd to_pulls;  ///< lower triangular: the pulls at the pivots, of those targets
  };

  void hold_shells(const std::vector<int>& point_of_vertex, const PolygonMesh& mesh, const ConstraintSet& set);
  void add_handles(const std::vector<int>& point_of_vertex, const PolygonMesh& mesh, const std::vector<double>& areas,
                   double stiffness, const ConstraintSet& set, const MeterPart& meter);
  void add_rows(Handle handle, double stiffness, const MeterPart& meter);
  /// @param first  of its rows
  [[nodiscard]] Positions targets_of(const Handle& handle, int first, const Positions& of_set) const;
  void add_patch(const std::vector<int>& point_of_vertex, const ConstraintSet& set, int p);
  void add_shells();
  void add_row(const Eigen::RowVectorXd& row, double weight, int source, int handle);

  /// (n_parts,) the shell that has most of the weights of each part of the mesh.
  [[nodiscard]] std::vector<int> homes_of_parts(const std::vector<int>& point_of_vertex, const PolygonMesh& mesh) const;
  /// (n, n_shells) how much of the weights of each point each shell has; sums of 1.
  [[nodiscard]] Eigen::MatrixXd shares_of_shells(std::span<const int> points) const;

  const CagePoints* points_ = nullptr;
  const PolygonMesh* cage_ = nullptr;
  LinearRows rows_;
  std::vector<int> handle_of_row_;
  std::vector<int> sources_;
  std::vector<Handle> handles_;
  std::vector<char> is_held_;  ///< of each shell
  std::vector<int> home_of_part_;
  std::vector<int> shell_rows_;  ///< the vertices of those that stay
  std::vector<int> parts_at_rest_;
};

}  // namespace arap
