// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "arap/mesh.h"
#include "arap/options.h"
#include "cell_energy.h"
#include "triangles.h"

namespace arap {

/// Assembles the energy of a surface; cell i belongs to vertex i. With e_ij = p_i - p_j and s_i the stiffness,
///
/// spokes [SA07] Eq. (7):  E = sum_i s_i sum_{j in N(i)} w_ij |e'_ij - R_i e_ij|^2,  w_ij = sum of max(0, 1/2 cot) over
/// the
///     triangles at the edge. Departure: single negative cotangents count as 0, since with negative weights the energy
///     can be unbounded below.
/// spokes-and-rims [CPSS10]:  E = 1/3 sum_i s_i sum_{f at i} sum_{(a,b) in f} 1/2 cot_ab |e'_ab - R_i e_ab|^2. The sum
/// over a
///     triangle is non-negative whatever the signs of its cotangents.
///
/// @param stiffness  (n,) > 0, or empty: 1
/// @param on_matrix     is called as soon as K is there, before the cells: what needs only that may begin
[[nodiscard]] CellEnergy assemble_surface_energy(const PolygonMesh& mesh, const Options& options,
                                                 const std::vector<double>& stiffness, int threads,
                                                 const Progress& progress,
                                                 const std::function<void(const SparseMatrix& K)>& on_matrix = {});

}  // namespace arap
