// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "arap/options.h"
#include "arap/result.h"
#include "arap/types.h"

namespace arap {

/// How the turns and scales of handles spread over a surface.
enum class Propagation {
  kHarmonic,  ///< as harmonic functions, with the matrix of the solve [ZRKS05]; knows handles that touch, and strengths
  kGeodesic,  ///< by 1 / distance along the edges [YZX04]: between two handles it falls off evenly
};

inline namespace ARAP_COMPILED_ALIKE {

/// Fixed at bind.
struct PoissonOptions {
  Propagation propagation = Propagation::kHarmonic;

  /// Threads of bind and solve; 0 = as many as pay at this size.
  int threads = 0;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// Poisson mesh editing: each face takes a turn and a scale from the handles, and the surface is the one whose
/// gradients are nearest to those of the faces. The model is linear in positions, so a solve is one step, the cheapest
/// of all models. It is as good as the turns: handles that are moved without a turn pull cones. Single vertices and
/// patches tell no turn by their targets; give it.
///
/// [YZX04]  Yu, Zhou, Xu, Shi, Bao, Guo, Shum: Mesh Editing with Poisson-Based Gradient Field Manipulation,
///          SIGGRAPH 2004.
/// [ZRKS05] Zayer, Roessl, Karni, Seidel: Harmonic Guidance for Surface Deformation, Eurographics 2005.
///
/// The same three acts as SurfaceArap, with the same rules. Of a face only its shape at rest counts: there are neither
/// stiffness nor rigid regions.
class PoissonEditing {
 public:
  /// Binds. Throws InvalidInput for bad options, Cancelled when `progress` returns false.
  explicit PoissonEditing(const PolygonMesh& mesh, const PoissonOptions& options = {}, const Progress& progress = {});
  ~PoissonEditing();
  PoissonEditing(PoissonEditing&&) noexcept;
  PoissonEditing& operator=(PoissonEditing&&) noexcept;
  PoissonEditing(const PoissonEditing&) = delete;
  PoissonEditing& operator=(const PoissonEditing&) = delete;

  /// As SurfaceArap::set_constraints: hard and soft vertices, and patches. With Propagation::kGeodesic each connected
  /// group of constrained vertices and each patch is a handle, and a handle takes a twentieth of a second and 1.2 MB at
  /// 100,000 vertices.
  void set_constraints(const ConstraintSet& constraints, const Progress& progress = {});

  /// Moves the mesh to `targets`, in double precision. The result follows from the targets alone, but for whole turns:
  /// a handle turns on from the last solve by less than half a turn, so that in steps it may turn as far as it likes.
  /// @param targets    as for SurfaceArap::solve
  /// @param options    only the initial guess counts: all but InitialGuess::kPrevious turn the short way from rest
  /// @param rotations  of each target's handle: the linear part of its motion since rest, a rotation times a uniform
  ///                   scale > 0. Of other matrices the rotation is the nearest one, the scale the third root of the
  ///                   determinant. Empty: rotations as SurfaceArap::solve estimates them, without scale
  /// @param progress   a cancelled solve returns the former positions and changes nothing
  /// @param out        as there
  /// @return  of one iteration; its energies are 0, since none is measured
  /// Throws InvalidInput, also for a determinant that is not above 0, or SolverError; the positions stay.
  SolveResult solve(const Positions& targets, const SolveOptions& options = {}, std::span<const Matrix3> rotations = {},
                    const Progress& progress = {}, std::span<float> out = {});

  /// Back to the rest positions, without turns; constraints stay.
  void reset();

  /// Shows `positions`, (n, 3), finite, until the next solve, which does not depend on them. Throws InvalidInput.
  void set_positions(const Positions& positions);

  /// (n, 3) where the mesh is now, in the input's space.
  [[nodiscard]] Positions positions() const;

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
