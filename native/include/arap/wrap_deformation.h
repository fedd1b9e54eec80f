// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// Fixed at bind.
struct WrapOptions {
  /// Vertices of the surface that a point hangs on, 1 to 64; deep inside they are more.
  int anchors = 12;

  /// Points near the surface keep their distance from it, on the side where they were at rest.
  bool stay_outside = true;

  /// Threads of all calls; 0 = as many as pay for so many points.
  int threads = 0;

  /// Throws InvalidInput that names field, value and bound.
  void validate() const;
};

/// A surface at rest, ready for binds: what they need of it, whatever the points are. That is nearly all of the work
/// where the surface is large and the points are few, so many binds to one surface share it. Bound points do not need
/// it. It takes about 150 bytes a vertex.
///
/// Never changes: several threads may bind to it at once.
class WrapSurface {
 public:
  /// @param surface  at rest, in any state
  /// @param threads  0 = as many as pay for so many vertices
  /// Throws InvalidInput; Cancelled when `progress` returns false; NotEnoughMemory.
  explicit WrapSurface(const PolygonMesh& surface, int threads = 0, const Progress& progress = {});
  ~WrapSurface();
  WrapSurface(WrapSurface&&) noexcept;
  WrapSurface& operator=(WrapSurface&&) noexcept;
  WrapSurface(const WrapSurface&) = delete;
  WrapSurface& operator=(const WrapSurface&) = delete;

  [[nodiscard]] int n_vertices() const;

 private:
  friend class WrapDeformation;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Points that a deforming surface carries along, inside or outside of it: clothes, hair cards, eyes. A wrap deformer.
///
///     x' = sum_j a_j (p'_j + B_j (x - p_j)),     a_j ~ ((R - d_j) / (R d_j))^2
///
/// over anchors p_j near the point, vertices of the surface at the distances d_j; R is a little beyond the farthest
/// [Franke 1982]. B_j is the gradient of the surface's motion around the anchor: least squares over its neighbours, and
/// the normal grows as the root of the area. So translation, rotation and uniform scale are met exactly.
///
/// The anchors of a point are connected along the surface with the vertex nearest to it, through vertices that are
/// near, too: a ring takes nothing from the next finger. The farther a point is from the surface, the coarser are its
/// anchors, so that it does not follow what is small. A point deep inside, as on a bone, hangs on the walls all around,
/// as far as twice the distance of the nearest: so it does not leave its neighbours that are nearer to another wall.
///
/// The surface may be any: open, not manifold, turned inside out, loose triangles, points without faces. Vertices at
/// the same place are one.
///
/// What stays outside keeps its distance from the plane of the triangle nearest to it at rest, which goes along. Where
/// the surface overlaps itself, a point that is outside of its own part may still be inside of another one; nothing
/// local can help there.
///
/// Different objects may run in different threads, and so may const functions of one.
class WrapDeformation {
 public:
  /// @param surface         at rest
  /// @param points          (n, 3) at rest, finite, at least one
  /// @param piece_of_point  (n,) or empty: points of the same number >= 0 move as one rigid body, the best fit to what
  ///                        they would do without; -1: the point bends with the surface
  /// Throws InvalidInput for bad options or arrays; Cancelled when `progress` returns false; NotEnoughMemory.
  WrapDeformation(const WrapSurface& surface, const Positions& points, const WrapOptions& options = {},
                  const std::vector<int>& piece_of_point = {}, const Progress& progress = {});
  /// The same, to a surface that nothing else is bound to.
  WrapDeformation(const PolygonMesh& surface, const Positions& points, const WrapOptions& options = {},
                  const std::vector<int>& piece_of_point = {}, const Progress& progress = {});
  ~WrapDeformation();
  WrapDeformation(WrapDeformation&&) noexcept;
  WrapDeformation& operator=(WrapDeformation&&) noexcept;
  WrapDeformation(const WrapDeformation&) = delete;
  WrapDeformation& operator=(const WrapDeformation&) = delete;

  /// Where the points go, (n, 3), finite.
  /// @param surface_positions  (n_vertices, 3) of the surface; those that the points hang on are finite
  /// Throws InvalidInput.
  [[nodiscard]] Positions deform(const Positions& surface_positions) const;
  /// The same in single precision, so that a frame need not allocate.
  /// @param out  (3 n) takes the result, row by row; is any, if it has a number beyond single precision, which throws
  void deform(const Positions& surface_positions, std::span<float> out) const;
  /// The same from single precision, too, without a copy of the surface.
  /// @param surface_positions  (3 n_vertices), row by row
  void deform(std::span<const float> surface_positions, std::span<float> out) const;

  [[nodiscard]] int n_points() const;
  [[nodiscard]] int n_vertices() const;  ///< of the surface
  [[nodiscard]] int n_pieces() const;    ///< that are rigid
  [[nodiscard]] int threads() const;     ///< threads in use

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
