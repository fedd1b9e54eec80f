// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "arap/types.h"
#include "cages/cage.h"

namespace arap {

/// Green coordinates [LLC08] of a point in a cage, in the cage's space.
struct GreenCoordinates {
  Eigen::VectorXd vertices;   ///< (n_vertices,), of sum 1
  Eigen::VectorXd triangles;  ///< (n_triangles,) lengths, along the normals
  bool is_inside = false;     ///< else the rest means nothing: it is outside, or on a face to 1e-12
};

/// With L_e = ln((r_a + r_b + l) / (r_a + r_b - l)) of an edge of length l, its ends r_a and r_b away, and Omega the
/// solid angle of a triangle,
///
///     phi_i = per_height_i / 4 pi (h_i Omega + d sum_e <m_i, m_e> L_e),    psi = (sum_e h_e L_e - d Omega) / 4 pi.
///
/// The printed algorithm of [LLC08] divides by zero where a point projects onto an edge's line; this form has no cases.
[[nodiscard]] GreenCoordinates green_coordinates(const Cage& cage, const Eigen::RowVector3d& point);

/// How often the cage winds around a point that is not on it: 1 inside, 0 outside.
[[nodiscard]] double winding_number(const Cage& cage, const Eigen::RowVector3d& point);

/// Of each triangle, the vector that its coordinate is of, (n_triangles, 3): the unit normal times the stretch
/// s = sqrt((|u'|^2 |v|^2 - 2 (u'.v') (u.v) + |v'|^2 |u|^2) / 8) / A [LLC08], u and v two of its edges.
/// @param moved  (n_vertices, 3) in any unit
[[nodiscard]] Positions stretched_normals(const Cage& cage, const Positions& moved);

}  // namespace arap
