// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/options.h"
#include "arap/result.h"
#include "arap/tet_mesh.h"
#include "arap/types.h"
#include "arap/vertex_properties.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// Fixed at bind.
struct TetOptions {
  /// Threads of bind and solve; 0 = as many as pay at this size.
  int threads = 0;

  /// For comparisons only: see Options::solver_factory.
  const SolverFactory* solver_factory = nullptr;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// As-rigid-as-possible deformation of a solid that the caller has cut into tetrahedra [CPSS10]. The energy is
/// sum_t V_t s_t |F_t - R_t|^2 over the tetrahedra, with V_t their volume at rest, F_t their deformation gradient and
/// R_t the rotation nearest to it. The unknowns are the vertices. (Tags of papers are expanded in surface_arap.h.)
///
/// The same three acts as SurfaceArap, with the same rules. A point inside of a tetrahedron is constrained as a patch:
/// its four vertices with the point's barycentric coordinates as weights.
///
/// Tetrahedra may be flat, down to a millionth of their width; of far flatter ones set_constraints throws SolverError.
class TetArap {
 public:
  /// Binds. Throws InvalidInput for bad options or properties, or a tetrahedron so small that it vanishes beside the
  /// mesh; Cancelled when `progress` returns false.
  /// @param properties  the stiffness s_t of a tetrahedron is the geometric mean of its vertices'. One whose vertices
  ///                    are all in rigid regions turns with the region that has most of them
  explicit TetArap(const TetMesh& mesh, const TetOptions& options = {}, const VertexProperties& properties = {},
                   const Progress& progress = {});
  ~TetArap();
  TetArap(TetArap&&) noexcept;
  TetArap& operator=(TetArap&&) noexcept;
  TetArap(const TetArap&) = delete;
  TetArap& operator=(const TetArap&) = delete;

  /// As SurfaceArap::set_constraints.
  void set_constraints(const ConstraintSet& constraints, const Progress& progress = {});

  /// As SurfaceArap::solve.
  SolveResult solve(const Positions& targets, const SolveOptions& options = {}, std::span<const Matrix3> rotations = {},
                    const Progress& progress = {}, std::span<float> out = {});

  /// Back to the rest positions; constraints stay.
  void reset();

  /// Starts the next solve from `positions`, (n, 3), finite. Throws InvalidInput.
  void set_positions(const Positions& positions);

  /// (n, 3) where the mesh is now, in the input's space.
  [[nodiscard]] Positions positions() const;

  /// The energy that a solve minimizes, without constraint terms, in the input's unit cubed. Each rigid region uses the
  /// best-fit rotation of its vertices. Throws InvalidInput, or SolverError where it is too large for a number.
  [[nodiscard]] double energy(const Positions& positions);

  /// (n, 3) gradient of energy().
  [[nodiscard]] Positions energy_gradient(const Positions& positions);

  [[nodiscard]] int n_vertices() const;
  [[nodiscard]] int n_parts() const;
  [[nodiscard]] const std::vector<int>& part_of_vertex() const;  ///< (n,), -1 = loose
  [[nodiscard]] const std::vector<int>& loose_vertices() const;  ///< vertices in no tetrahedron
  [[nodiscard]] int n_parts_at_rest() const;                     ///< without any constraint; 0 before set_constraints()
  [[nodiscard]] int n_factorizations() const;                    ///< numeric factorizations since bind
  [[nodiscard]] int threads() const;                             ///< threads in use

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
