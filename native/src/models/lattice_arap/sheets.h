// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "arap/surface_arap.h"
#include "lattice/lattice.h"

namespace arap {

/// Parts of a mesh that a lattice has no cubes of, because they have no inside: cloth, leaves, hair cards. They are
/// posed as surfaces beside it. All positions and vertices are those of the lattice's mesh, in its space.
class Sheets {
 public:
  /// @param mesh        of diagonal 1
  /// @param properties  of its vertices
  Sheets(const PolygonMesh& mesh, const Lattice& lattice, const VertexProperties& properties, int threads,
         const Progress& progress);

  [[nodiscard]] bool empty() const { return !surface_.has_value(); }

  /// Of a set of the mesh, those on sheets. The former ones stay if it throws.
  void set_constraints(const ConstraintSet& of_mesh, const Progress& progress);

  /// @param targets, rotations  of the whole set
  /// @return  what the surface did; without constraints, as if it had converged at rest
  SolveResult solve(const Positions& targets, SolveOptions options, std::span<const Matrix3> rotations,
                    const Progress& progress);

  /// Writes where they are to the positions of the mesh.
  void write(Positions& points) const;
  void reset();
  /// Of vertices(), row by row.
  [[nodiscard]] Positions positions() const { return empty() ? Positions(0, 3) : surface_->positions(); }
  void set_positions(const Positions& positions);

  /// Of the mesh: those that the constraints hold something of.
  [[nodiscard]] const std::vector<int>& constrained_parts() const { return constrained_; }
  /// Of the mesh, ascending, as the parts are.
  [[nodiscard]] const std::vector<int>& vertices() const { return vertices_; }
  [[nodiscard]] const std::vector<int>& parts() const { return parts_; }
  [[nodiscard]] int n_factorizations() const { return empty() ? 0 : surface_->n_factorizations(); }

 private:
  [[nodiscard]] PolygonMesh cut_out(const PolygonMesh& mesh);

  std::vector<int> vertices_;           ///< of the mesh, by vertex of the surface
  std::vector<int> number_;             ///< of the surface, by vertex of the mesh; -1: on no sheet
  std::vector<int> parts_;              ///< of the mesh, by part of the surface
  std::vector<int> constrained_;        ///< parts of the mesh
  double size_ = 1;                     ///< the surface's diagonal
  std::optional<SurfaceArap> surface_;  ///< none: all parts have cubes
  std::vector<int> targets_;            ///< rows of the whole set's targets, by target of the surface
};

}  // namespace arap
