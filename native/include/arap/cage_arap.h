// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "arap/cage.h"
#include "arap/constraints.h"
#include "arap/mesh.h"
#include "arap/options.h"
#include "arap/result.h"
#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// Whose shape resists.
enum class CageEnergy {
  kMesh,  ///< the surface of the mesh [HSL06]: limbs keep more of their volume
  kCage,  ///< the surface of the cage: a frame costs less
};

/// Fixed at bind.
struct CageArapOptions {
  CageEnergy energy = CageEnergy::kMesh;

  /// kMeanValue or kHarmonic: kGreen is not linear in the cage.
  CageCoordinates coordinates = CageCoordinates::kMeanValue;

  /// As in CageOptions.
  double grid_spacing = CageOptions().grid_spacing;

  /// Distance between the rotation nodes of that surface, as a fraction of the mesh's bounding-box diagonal. Larger is
  /// stiffer. In [1e-6, 1].
  double rigidity_radius = 0.05;

  /// Threads of bind and solve; 0 = as many as pay at this size.
  int threads = 0;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// As-rigid-as-possible deformation of a cage by vertices of the mesh that hangs on it. The unknowns are the vertices
/// of the cage, and rotations those of nodes, so an iteration costs the same at every density of the mesh. Cages of
/// some hundreds of vertices are meant: a bind takes time as their square, a set of constraints also as their cube.
///
/// [HSL06] Huang, Shi, Liu, Zhou, Wei, Teng, Bao, Guo, Shum: Subspace Gradient Domain Mesh Deformation, SIGGRAPH 2006.
///
/// The same three acts as SurfaceArap. All parts of the mesh go where the cage carries them. Loose vertices stay, and
/// so do connected shells of the cage that no constrained vertex feels, or that are around parts without constraints.
/// What is in them is at rest with harmonic coordinates. With mean values it may move a little, as it feels all shells.
class CageArap {
 public:
  /// @param cage  around the mesh, at rest: as for CageDeformation; make_cage() makes one
  /// Throws InvalidInput for bad options, a mesh without faces or size, or what CageDeformation refuses; Cancelled when
  /// `progress` returns false.
  CageArap(const PolygonMesh& mesh, const PolygonMesh& cage, const CageArapOptions& options = {},
           const Progress& progress = {});
  ~CageArap();
  CageArap(CageArap&&) noexcept;
  CageArap& operator=(CageArap&&) noexcept;
  CageArap(const CageArap&) = delete;
  CageArap& operator=(const CageArap&) = delete;

  /// As SurfaceArap::set_constraints, but for the unit of strengths: s < 1 adds omega_v |p'_v - target|^2 with
  /// omega_v = k a_v s / (1 - s), k the mean of K_ii, a_v the area at the vertex over that at a vertex of the cage. If
  /// connected constrained vertices have less than 1 of these together, each gets as much more. So a region pulls as
  /// firmly at every density of the mesh. For hard ones s / (1 - s) is 1e4: the cage brings them as near to their
  /// targets as it can, a region to about a thousandth of the size. Patches are held exactly. Throws NotEnoughMemory,
  /// too.
  void set_constraints(const ConstraintSet& constraints, const Progress& progress = {});

  /// As SurfaceArap::solve.
  SolveResult solve(const Positions& targets, const SolveOptions& options = {}, std::span<const Matrix3> rotations = {},
                    const Progress& progress = {}, std::span<float> out = {});

  /// Back to the rest positions; constraints stay.
  void reset();

  /// Starts the next solve from about `positions`, (n, 3), finite: as near to them as the cage can be, see
  /// CageDeformation::fit(). Throws InvalidInput.
  void set_positions(const Positions& positions);

  /// (n, 3) where the mesh is now, in the input's space.
  [[nodiscard]] Positions positions() const;
  /// (n_cage_vertices, 3) where the cage is now.
  [[nodiscard]] Positions cage_positions() const;

  [[nodiscard]] int n_vertices() const;  ///< of the mesh
  [[nodiscard]] int n_cage_vertices() const;
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
