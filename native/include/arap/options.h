// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

namespace arap {

class SolverFactory;

/// What one rotation stands for. Tags of papers are expanded in surface_arap.h.
enum class Energy {
  kRotationNodes,  ///< a round piece of the surface, of the same size at every density of the mesh
  kSpokesAndRims,  ///< a vertex and all edges of the triangles at it [CPSS10]
  kSpokes,         ///< a vertex and the edges at it [SA07]
};

enum class EdgeWeights {
  kCotangent,  ///< depends on the shape of the triangles, hardly on how the surface is cut into them
  kUniform,    ///< every triangle edge counts the same, whatever its shape
};

/// Where the iteration starts. Constrained vertices always start at their targets.
enum class InitialGuess {
  kPrevious,         ///< the positions of the last solve, rotated on with the handles: for drags
  kRest,             ///< the rest positions
  kNaiveLaplacian,   ///< min |L p' - L p|^2 under the constraints, as [SA07] starts
  kHandleRotations,  ///< the handles' rotations propagated harmonically, then one global step
};

/// How an iteration goes on from a local and a global step.
enum class Acceleration {
  kConjugateGradients,  ///< combines the global steps; five to fifty times fewer iterations, the same minimum
  kNone,                ///< plain local/global [SA07]
};

enum class StopReason { kConverged, kMaxIterations, kTimeLimit, kCancelled };

/// Fixed at bind.
struct Options {
  /// Rotation nodes look the same at every density of the mesh and take few iterations. The others are the classics:
  /// the finer the mesh, the softer they are. Of these spokes-and-rims bends more evenly.
  Energy energy = Energy::kRotationNodes;

  /// For rotation nodes: the distance between them, as a fraction of the bounding-box diagonal.
  /// Larger is stiffer: folds get wider. In [1e-6, 1].
  double rigidity_radius = 0.02;

  /// Cotangent for surfaces; uniform for meshes whose triangles are so bad that cotangents mean nothing.
  EdgeWeights weights = EdgeWeights::kCotangent;

  /// Threads of bind and solve; 0 = as many as pay at this size. Set it to 1 if other work needs the cores.
  int threads = 0;

  /// Treats vertices at the same place (an open seam) as one, so the seam cannot open. PolygonMesh::same_places says
  /// which.
  bool join_seams = false;

  /// For comparisons only: makes another sparse solver than the library's own; must outlive the model. Its class is no
  /// part of the public interface.
  const SolverFactory* solver_factory = nullptr;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// Given to every solve.
struct SolveOptions {
  InitialGuess initial_guess = InitialGuess::kPrevious;

  /// Upper bound of iterations, each a global and a local step; a frame of a drag takes few, a bake many. >= 1.
  int max_iterations = 1000;

  /// Stop when every vertex is within this distance of the minimizer, estimated from the last steps, or when steps are
  /// lost in rounding; 0: for neither. A fraction of the diagonal at rest, >= 0. A tenth takes a dozen iterations more.
  /// Iterations switch from single to double precision near the end; below 1e-7, and on small meshes, all are in
  /// double.
  double accuracy = 1e-6;

  /// Soft limit of wall-clock time in seconds; infinity = none. > 0. A new iteration starts only if the median of the
  /// last ones says that it will fit. At least one iteration runs, and handing over the positions comes on top. The
  /// next solve to the same targets continues where this one stopped.
  double time_limit_s = std::numeric_limits<double>::infinity();

  /// For comparisons only.
  Acceleration acceleration = Acceleration::kConjugateGradients;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

}  // namespace arap
