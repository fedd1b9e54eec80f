// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "models/surface_arap/posed_surface.h"

namespace arap {

/// Parts of a mesh that a lattice has no cubes of, because they have no inside: cloth, leaves, hair cards. They are
/// posed as surfaces beside it. All positions and vertices are those of the lattice's mesh, in its space.
class Sheets {
 public:
  /// @param mesh        of diagonal 1
  /// @param properties  of its vertices
  Sheets(const PolygonMesh& mesh, const Lattice& lattice, const VertexProperties& properties, int threads,
         const Progress& progress);

  [[nodiscard]] bool empty() const { return surface_ == nullptr; }

  /// Constraints, to take() once nothing can fail any more.
  struct Change {
    VertexModel::Change of_surface;
    std::vector<int> targets;
    std::vector<int> constrained_parts;  ///< of the mesh: those that the constraints hold something of
  };
  /// Of a set of the mesh, those on sheets.
  [[nodiscard]] Change prepare(const ConstraintSet& of_mesh, const Progress& progress);
  void take(Change change) noexcept;

  /// @param targets, rotations  of the whole set
  /// @return  what the surface did; without constraints, as if it had converged at rest
  SolveResult solve(const Positions& targets, SolveOptions options, std::span<const Matrix3> rotations,
                    const Progress& progress);

  /// Writes where they are to the positions of the mesh.
  void write(Positions& points) const;
  /// @param positions  of vertices(), row by row
  [[nodiscard]] Pose fitted(const Positions& positions) { return empty() ? Pose() : surface_->posed.fitted(positions); }
  [[nodiscard]] Pose at_rest() const { return empty() ? Pose() : surface_->posed.at_rest(); }
  void take(Pose pose) noexcept;
  /// As Engine::undo().
  void undo() noexcept;

  /// Of the mesh, ascending, as the parts are.
  [[nodiscard]] const std::vector<int>& vertices() const { return vertices_; }
  [[nodiscard]] const std::vector<int>& parts() const { return parts_; }
  [[nodiscard]] int n_factorizations() const { return empty() ? 0 : surface_->posed.n_factorizations(); }

 private:
  [[nodiscard]] PolygonMesh cut_out(const PolygonMesh& mesh);

  std::vector<int> vertices_;              ///< of the mesh, by vertex of the surface
  std::vector<int> number_;                ///< of the surface, by vertex of the mesh; -1: on no sheet
  std::vector<int> parts_;                 ///< of the mesh, by part of the surface
  double size_ = 1;                        ///< the surface's diagonal
  std::unique_ptr<PosedSurface> surface_;  ///< none: all parts have cubes
  std::vector<int> targets_;               ///< rows of the whole set's targets, by target of the surface
};

}  // namespace arap
