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
#include "arap/vertex_properties.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// Fixed at bind.
struct LatticeOptions {
  /// Size of the cubes as a fraction of the bounding-box diagonal, in [0.001, 1]; 0: from the shape, the smaller of
  /// 0.02 and a quarter of the median thickness. Coarser is faster and stiffer.
  double cube_size = 0;

  /// In [0, 1]: how firmly each place inside keeps its volume. 0: as the shape makes it; 1: limbs hardly get thinner,
  /// at about twice the iterations.
  double keep_volume = 0;

  /// Threads of bind and solve; 0 = as many as pay at this size.
  int threads = 0;

  /// As in Options.
  bool join_seams = false;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// As-rigid-as-possible deformation of a surface and what is inside it. A limb that is twisted or bent keeps its
/// volume, which a surface alone does not. The unknowns are the control points of a sparse lattice of quadratic
/// B-splines around the mesh, so an iteration costs the same at every density of the mesh.
///
/// The same three acts as SurfaceArap, with the same rules. Any mesh serves: open, not manifold, of several parts,
/// turned inside out. A closed part inside of another one and turned the other way is its void, and one part with it.
/// Parts without an inside, as sheets, are posed as surfaces beside the others, with default
/// options. If no part has an inside, the cubes that they pass through carry them: see has_inside().
class LatticeArap {
 public:
  /// Binds. Throws InvalidInput for bad options or properties, or a mesh without faces or size; Cancelled when
  /// `progress` returns false.
  /// @param properties  a cube is as stiff as the vertices in it. A rigid region is exactly rigid: what the lattice
  ///                    bends of it is spread around it
  explicit LatticeArap(const PolygonMesh& mesh, const LatticeOptions& options = {},
                       const VertexProperties& properties = {}, const Progress& progress = {});
  ~LatticeArap();
  LatticeArap(LatticeArap&&) noexcept;
  LatticeArap& operator=(LatticeArap&&) noexcept;
  LatticeArap(const LatticeArap&) = delete;
  LatticeArap& operator=(const LatticeArap&) = delete;

  /// As SurfaceArap::set_constraints, but for the unit of strengths: s < 1 adds omega_v |p'_v - target|^2 with
  /// omega_v = s / (1 - s) times the area at the vertex over the size of a cube, or more if a cube has little area that
  /// is constrained. The lattice follows constrained vertices as well as it can; what it leaves of hard ones is spread
  /// over two cubes around them, so these are exactly at their targets.
  /// Segments are held softly: a tug of war between bones and hard vertices is a compromise. Throws InvalidInput for a
  /// segment outside, too: see segments_outside().
  void set_constraints(const ConstraintSet& constraints, const Progress& progress = {});

  /// As SurfaceArap::solve.
  SolveResult solve(const Positions& targets, const SolveOptions& options = {}, std::span<const Matrix3> rotations = {},
                    const Progress& progress = {}, std::span<float> out = {});

  /// Indices of those segments that pass through nothing that is inside, so they can hold nothing. A place is inside to
  /// a quarter of a cube.
  [[nodiscard]] std::vector<int> segments_outside(const std::vector<Segment>& segments) const;

  /// Back to the rest positions; constraints stay.
  void reset();

  /// Starts the next solve from about `positions`, (n, 3), finite: as near to them as the lattice can be. Throws
  /// InvalidInput.
  void set_positions(const Positions& positions);

  /// (n, 3) where the mesh is now, in the input's space.
  [[nodiscard]] const Positions& positions() const;

  [[nodiscard]] int n_vertices() const;
  [[nodiscard]] int n_parts() const;
  /// n_parts() of a model of `mesh` with its seams joined; see PolygonMesh::n_parts_joined().
  [[nodiscard]] static int n_parts_joined(const PolygonMesh& mesh, int threads = 1);
  [[nodiscard]] const std::vector<int>& part_of_vertex() const;  ///< (n,), -1 = loose
  [[nodiscard]] const std::vector<int>& loose_vertices() const;  ///< vertices in no face
  [[nodiscard]] int n_parts_at_rest() const;                     ///< without any constraint; 0 before set_constraints()
  [[nodiscard]] int n_factorizations() const;                    ///< numeric factorizations since bind
  [[nodiscard]] int n_control_points() const;
  [[nodiscard]] bool has_inside() const;                 ///< false: a surface model bends this mesh better
  [[nodiscard]] const std::vector<int>& sheets() const;  ///< parts that are posed as surfaces, ascending
  [[nodiscard]] double cube_size() const;                ///< in the input's unit
  /// (8 n_cubes, 3) where the corners of the cubes are now, in the input's space. Corner 4 x + 2 y + z of a cube is at
  /// its low (0) or high (1) end along each axis. Cubes in which several pieces move by themselves are there as often.
  [[nodiscard]] Positions cube_corners() const;
  [[nodiscard]] int threads() const;  ///< threads in use

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
