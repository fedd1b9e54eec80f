// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// How a point hangs on a cage.
///
/// [JSW05] Ju, Schaefer, Warren: Mean Value Coordinates for Closed Triangular Meshes, SIGGRAPH 2005.
/// [JMD07] Joshi, Meyer, DeRose, Green, Sanocki: Harmonic Coordinates for Character Articulation, SIGGRAPH 2007.
/// [LLC08] Lipman, Levin, Cohen-Or: Green Coordinates, SIGGRAPH 2008.
/// [CHSB10] Chen, Huang, Sun, Bao: Cage-based deformation transfer, Computers & Graphics 34(2), 2010.
/// [SP04] Sumner, Popovic: Deformation Transfer for Triangle Meshes, SIGGRAPH 2004.
enum class CageCoordinates {
  /// [JSW05]: follows the cage closely and meets affine motions exactly. Defined everywhere, also outside of the cage.
  kMeanValue,
  /// [LLC08]: keeps shapes, as it turns what a cage shears, but follows the cage less closely. Meets similarities
  /// exactly (translation, rotation, even scale), other affine motions not. Defined inside of the cage only.
  kGreen,
  /// [JMD07]: as mean values, but never below 0 (to a thousandth), and a limb follows its own part of the cage alone.
  /// From a grid, so it takes longer and is right to about a hundredth. Defined inside of the cage and on it.
  kHarmonic,
};

/// Fixed when the weights are computed.
struct CageOptions {
  CageCoordinates coordinates = CageCoordinates::kMeanValue;

  /// For kHarmonic: distance of the grid's nodes as a fraction of the cage's bounding-box diagonal, in [0.005, 0.1].
  /// Finer where the cage has narrow places; half of it takes about ten times as long.
  double grid_spacing = 1. / 64;

  /// Threads of all calls; 0 = as many as pay for so many points.
  int threads = 0;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// The weights of a point.
struct CageWeights {
  Eigen::VectorXd vertices;   ///< (n_vertices,), of sum 1
  Eigen::VectorXd triangles;  ///< (n_triangles,) lengths in the cage's unit; empty but for kGreen
};

/// Points that a coarse closed mesh around them carries: a cage. Where its vertices move, they follow, by fixed
/// weights:
///
///     p' = sum_i w_i c'_i                                    (kMeanValue, kHarmonic)
///     p' = sum_i phi_i c'_i + sum_t psi_t s_t n'_t           (kGreen)
///
/// with c' the cage's vertices, and of its triangles n' the unit normals and s the stretch since rest.
///
/// The constructor computes the weights, deform() uses them: a product with a dense matrix in single precision. The
/// motion that fits the cage's best, affine or for kGreen a similarity, is applied to the points in double, and the
/// matrix carries only the rest of the motion, to 1e-7 of it. So what is exact in theory is exact to rounding in
/// double.
///
/// Different objects may run in different threads, and so may const functions of one.
class CageDeformation {
 public:
  /// @param cage    at rest: triangles and quads, closed, oriented alike, outwards or inwards
  /// @param points  (n, 3) at rest, finite, at least one. For kGreen farther inside than 1e-12 of the cage's diagonal,
  ///                for kHarmonic inside or on it, for kMeanValue within 1e30 diagonals
  /// Throws InvalidInput for bad options, cage or points; Cancelled when `progress` returns false.
  CageDeformation(const PolygonMesh& cage, const Positions& points, const CageOptions& options = {},
                  const Progress& progress = {});
  ~CageDeformation();
  CageDeformation(CageDeformation&&) noexcept;
  CageDeformation& operator=(CageDeformation&&) noexcept;
  CageDeformation(const CageDeformation&) = delete;
  CageDeformation& operator=(const CageDeformation&) = delete;

  /// Where the points go, (n, 3).
  /// @param cage_positions  (n_vertices, 3) of the cage, finite
  /// Throws InvalidInput.
  [[nodiscard]] Positions deform(const Positions& cage_positions) const;
  /// The same in single precision, so that a frame need not allocate.
  /// @param out  (3 n) takes the result, row by row; is any, if it has a number beyond single precision, which throws
  void deform(const Positions& cage_positions, std::span<float> out) const;

  /// Where the cage must be, (n_vertices, 3), so that the points come to given places as well as they can [CHSB10]:
  ///
  ///     min 1/n |Phi C' - positions|^2 + smoothness / n_vertices |L (C' - M C)|^2,
  ///
  /// Phi the weights, L of each vertex how far it is from the mean of its neighbours, n_vertices of those in faces.
  /// Departure: the smoothness is that of what the best turn, scale and shift M of the points leaves, so it does not
  /// resist these.
  /// @param positions   (n, 3) of the points, finite
  /// @param smoothness  1e-12 to 1: how smoothly the cage moves where points tell little
  /// Throws InvalidInput, also for kGreen, which is not linear in the cage; Cancelled when `progress` returns false.
  [[nodiscard]] Positions fit(const Positions& positions, double smoothness = 1e-6,
                              const Progress& progress = {}) const;

  /// The weights of a point in double: computed again, or for kHarmonic those that there are, repaired. Throws
  /// InvalidInput for an index out of [0, n_points).
  [[nodiscard]] CageWeights weights(int point) const;

  [[nodiscard]] int n_points() const;
  [[nodiscard]] int n_vertices() const;  ///< of the cage
  /// Of the cage. A quad has those of both its diagonals, four, if it is convex, with half a weight each.
  [[nodiscard]] int n_triangles() const;
  [[nodiscard]] int threads() const;  ///< threads in use

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A cage of quads around a mesh and what is inside of it: the outside of the cubes of a coarse grid that the mesh is
/// in or near, smoothed. The mesh may be open, or of several parts; holes smaller than a cube are closed. It is nowhere
/// nearer to the cage than a seventh of a cube, and finer grids follow it more closely.
/// @param cells     cubes along the longest side of the mesh's bounding box, 2 to 50; about 10 is meant
/// @param progress  may stop it
/// Throws InvalidInput for other numbers, or a mesh without faces or size; Cancelled.
[[nodiscard]] PolygonMesh make_cage(const PolygonMesh& mesh, int cells = 10, const Progress& progress = {});

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
