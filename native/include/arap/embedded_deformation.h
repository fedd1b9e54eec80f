// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/error.h"
#include "arap/mesh.h"
#include "arap/options.h"
#include "arap/result.h"
#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// How a node of the graph may move.
enum class GraphNodes {
  kAffine,  ///< by any affine map; a term of the energy draws it to a rotation [SSP07]
  kRigid,   ///< by a rotation and a translation: half the unknowns
};

/// Which nodes move a vertex.
enum class GraphWeights {
  kSmooth,   ///< all within twice the distance of nodes: weights (1 - d^2 / (2 r)^2)^2, no bumps
  kNearest,  ///< the four nearest: weights (1 - d / d_5)^2, d_5 the distance of the fifth, as published [SSP07] Eq. (4)
};

/// Fixed at bind.
struct EmbeddedOptions {
  /// Distance between nodes, as a fraction of the bounding-box diagonal. Smaller bends more sharply and is slower: half
  /// the distance makes four times as many nodes. In [0.005, 1].
  double node_distance = 0.05;

  GraphNodes nodes = GraphNodes::kAffine;
  GraphWeights weights = GraphWeights::kSmooth;

  /// Of the terms of the energy, all in [0.1, 1000] [SSP07] Sec. 4.
  double rotation_weight = 1;
  double regularization_weight = 10;
  double constraint_weight = 100;

  /// Threads of bind and solve; 0 = as many as pay at this size.
  int threads = 0;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// Embedded deformation: a sparse graph of nodes, each with a map of its own, moves the mesh.
///
/// [SSP07] Sumner, Schmid, Pauly: Embedded Deformation for Shape Manipulation, SIGGRAPH 2007.
///
/// A vertex v goes to sum_j w_j(v) (A_j (v - g_j) + g_j + t_j) over its nodes j at g_j. The energy is
/// w_rot E_rot + w_reg E_reg + w_con E_con, minimized by Newton steps. Departures: lengths are fractions of the
/// bounding-box diagonal, so that the result does not depend on the unit; distances are along the surface and straight
/// through thin limbs, so that limbs that touch stay apart; hard constraints are met, by multipliers; the weights of
/// all constraints sum to w_con times the number of nodes, so that a denser mesh is not held more strongly.
///
/// The same three acts as SurfaceArap. The cost of a frame hangs on the number of nodes, and little on the mesh.
class EmbeddedDeformation {
 public:
  /// Binds. Throws InvalidInput for bad options or a mesh without faces or size, Cancelled when `progress` returns
  /// false.
  explicit EmbeddedDeformation(const PolygonMesh& mesh, const EmbeddedOptions& options = {},
                               const Progress& progress = {});
  ~EmbeddedDeformation();
  EmbeddedDeformation(EmbeddedDeformation&&) noexcept;
  EmbeddedDeformation& operator=(EmbeddedDeformation&&) noexcept;
  EmbeddedDeformation(const EmbeddedDeformation&) = delete;
  EmbeddedDeformation& operator=(const EmbeddedDeformation&) = delete;

  /// As SurfaceArap::set_constraints, but for the unit of strengths: s < 1 adds c |v' - target|^2 to E_con with c =
  /// s / (1 - s) times the number of nodes over that of what is constrained, whatever K_ii is. So a denser mesh is held
  /// no more strongly. Hard vertices and patches are met as well as the nodes can: a few of them exactly.
  void set_constraints(const ConstraintSet& constraints, const Progress& progress = {});

  /// As SurfaceArap::solve; energies are pure numbers. An iteration is a Newton step. kHandleRotations starts
  /// from one rigid motion of the whole mesh that fits the targets best, kNaiveLaplacian at rest. Wherever it starts,
  /// the whole first moves rigidly if that alone leaves less than a tenth of the energy. Converged: the steps to come
  /// sum to less than the accuracy, or are lost in rounding, and hard constraints are met as well as the nodes can.
  /// Throws SolverError also where no step lowers the energy, as for targets 1e12 diagonals away.
  /// @param rotations  not used: a graph finds them
  SolveResult solve(const Positions& targets, const SolveOptions& options = {}, std::span<const Matrix3> rotations = {},
                    const Progress& progress = {}, std::span<float> out = {});

  /// Back to the rest positions; constraints stay.
  void reset();

  /// Starts the next solve from the nodes' motions that are nearest to `positions`, (n, 3), finite. Throws
  /// InvalidInput.
  void set_positions(const Positions& positions);

  /// (n, 3) where the mesh is now, in the input's space.
  [[nodiscard]] Positions positions() const;

  [[nodiscard]] Positions nodes() const;  ///< (m, 3) at rest, in the input's space
  [[nodiscard]] int n_nodes() const;
  [[nodiscard]] int n_vertices() const;
  [[nodiscard]] int n_parts() const;
  [[nodiscard]] const std::vector<int>& part_of_vertex() const;  ///< (n,), -1 = loose
  [[nodiscard]] const std::vector<int>& loose_vertices() const;  ///< vertices in no face
  [[nodiscard]] int n_parts_at_rest() const;                     ///< without any constraint; 0 before set_constraints()
  [[nodiscard]] int n_factorizations() const;                    ///< numeric ones since bind: steps of solves add some
  [[nodiscard]] int threads() const;                             ///< threads in use

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
