// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/error.h"
#include "arap/mesh.h"
#include "arap/options.h"
#include "arap/result.h"
#include "arap/types.h"
#include "arap/version.h"
#include "arap/vertex_properties.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// As-rigid-as-possible deformation of a surface.
///
/// [SA07]   Sorkine, Alexa: As-Rigid-As-Possible Surface Modeling, SGP 2007.
/// [CPSS10] Chao, Pinkall, Sanan, Schroeder: A Simple Geometric Model for Elastic Deformations, SIGGRAPH 2010.
///
/// Three acts with three costs: construction binds a mesh, set_constraints factorizes for a set of constrained
/// vertices, solve iterates to new targets. Nothing is recomputed that a change did not touch. Different objects may
/// run in different threads, and so may const functions of one; others need the object to themselves.
class SurfaceArap {
 public:
  /// Binds. Throws InvalidInput for bad options or properties, Cancelled when `progress` returns false.
  explicit SurfaceArap(const PolygonMesh& mesh, const Options& options = {}, const VertexProperties& properties = {},
                       const Progress& progress = {});
  ~SurfaceArap();
  SurfaceArap(SurfaceArap&&) noexcept;
  SurfaceArap& operator=(SurfaceArap&&) noexcept;
  SurfaceArap(const SurfaceArap&) = delete;
  SurfaceArap& operator=(const SurfaceArap&) = delete;

  /// Makes the set of constraints current and factorizes; does nothing if it equals the current one. Throws
  /// InvalidInput, SolverError or Cancelled, and then the former set stays current.
  void set_constraints(const ConstraintSet& constraints, const Progress& progress = {});

  /// Moves the mesh towards `targets`. A solve to the targets of the last one continues its search, unless energy() or
  /// energy_gradient() was called in between. A cancelled solve returns the former positions and changes nothing, but
  /// the next one begins a new search.
  /// @param targets    (k + n_patches, 3): one row per constrained vertex, then one per patch; finite
  /// @param rotations  for InitialGuess::kHandleRotations: the rotation of each target's handle, k + n_patches
  ///                   matrices; empty: estimated from the targets of each connected group of constrained vertices
  /// @param out        (3 n) takes the positions in single precision, row by row, so that a frame of a drag need not
  ///                   allocate; the result's own are then empty. Empty: they are in the result.
  /// Throws InvalidInput (the positions stay) or SolverError; `out` is then as it was, or the former positions.
  SolveResult solve(const Positions& targets, const SolveOptions& options = {}, std::span<const Matrix3> rotations = {},
                    const Progress& progress = {}, std::span<float> out = {});

  /// A round patch of the surface about `vertices`, for ConstraintSet::patches: a point handle that holds it pulls a
  /// smooth hill, the same at every density of the mesh; a constrained vertex would pull a spike. Its weights are
  /// area (1 - d^2 / radius^2)^3, d the distance along the surface to the nearest of `vertices`.
  /// @param radius  as a fraction of the rest bounding-box diagonal; 0: 1.5 times Options::rigidity_radius
  /// Throws InvalidInput: no vertices, an index out of range, a vertex in no face, a radius that is negative or not
  /// finite.
  [[nodiscard]] Patch patch_around(const std::vector<int>& vertices, double radius = 0);

  /// Back to the rest positions; constraints stay.
  void reset();

  /// Starts the next solve from `positions`, (n, 3), finite. Throws InvalidInput.
  void set_positions(const Positions& positions);

  /// (n, 3) where the mesh is now, in the input's space.
  [[nodiscard]] Positions positions() const;

  /// The energy that a solve minimizes, without constraint terms, in the input's unit squared: min over the rotations
  /// of E(positions, R), of which parts that hard vertices cut from each other have their own. Each rigid region uses
  /// the best-fit rotation of its vertices. Joined vertices are represented by the first one.
  [[nodiscard]] double energy(const Positions& positions);

  /// (n, 3) gradient of energy(); 0 at joined vertices other than the first.
  [[nodiscard]] Positions energy_gradient(const Positions& positions);

  [[nodiscard]] int n_vertices() const;
  [[nodiscard]] int n_parts() const;
  [[nodiscard]] const std::vector<int>& part_of_vertex() const;  ///< (n,), -1 = loose
  [[nodiscard]] const std::vector<int>& loose_vertices() const;  ///< vertices in no face
  [[nodiscard]] int n_parts_at_rest() const;                     ///< without any constraint; 0 before set_constraints()
  [[nodiscard]] int n_factorizations() const;                    ///< numeric factorizations since bind
  [[nodiscard]] int threads() const;                             ///< threads in use

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
