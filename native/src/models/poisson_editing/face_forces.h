// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "base/grouped.h"
#include "mesh/triangulation.h"
#include "parallel/workers.h"

namespace arap {

/// The right-hand side of Poisson editing. A face f has one turn and scale, s_f R_f: those of its corners, averaged. In
/// the form of CellEnergy a face is a cell with the rest vectors
///
///     q_fj = sum over its triangles, their edges jk at j, of cot (p_j - p_k),
///
/// and sum_f s_f R_f q_fj is twice the divergence of the guide gradients at vertex j, cot in place of area.
class FaceForces {
 public:
  FaceForces() = default;
  /// @param mesh           at rest
  /// @param triangulation  of it, with cotangents
  FaceForces(const PolygonMesh& mesh, const Triangulation& triangulation);

  /// Gives the vertices their numbers: v becomes new_of_old[v]. Must be called once before find().
  void renumber(const std::vector<int>& new_of_old);

  /// (n, 3) what drives the surface from rest: sum_f (s_f R_f - I) q_fj at vertex j.
  /// @param turns       (n, 3) rotation vectors
  /// @param log_scales  (n, 3), in the first column; no rows: all scales are 1
  [[nodiscard]] Positions find(const Positions& turns, const Positions& log_scales, const Workers& workers) const;

 private:
  /// Adds the triangles and ties of face f to its corners' rest vectors.
  class Reader;
  [[nodiscard]] int n_faces() const { return static_cast<int>(offsets_.size()) - 1; }
  /// s_f R_f - I.
  [[nodiscard]] Matrix3 change_of(int f, const Positions& turns, const Positions& log_scales) const;

  std::vector<int> offsets_{0};             ///< (n_faces + 1,) first corner of each face
  std::vector<int> vertices_;               ///< (n_corners,)
  Positions rest_vectors_;                  ///< (n_corners, 3); where a face names a vertex twice, at one of both
  Grouped corners_{0, [](const auto&) {}};  ///< by vertex
};

}  // namespace arap
