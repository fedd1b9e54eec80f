// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "arap/mesh.h"
#include "arap/options.h"
#include "energy/cell_energy.h"
#include "parallel/meter.h"
#include "sampling/rotation_nodes.h"

namespace arap {

/// Fills in the energy of a surface. With e_ij = p_i - p_j and s_i the stiffness,
///
/// spokes [SA07] Eq. (7):  E = sum_i s_i sum_{j in N(i)} w_ij |e'_ij - R_i e_ij|^2,  w_ij = sum of max(0, 1/2 cot) over
/// the
///     triangles at the edge. Departure: single negative cotangents count as 0, since with negative weights the energy
///     can be unbounded below.
/// spokes-and-rims [CPSS10]:  E = 1/3 sum_i s_i sum_{f at i} sum_{(a,b) in f} 1/2 cot_ab |e'_ab - R_i e_ab|^2. The sum
/// over a
///     triangle is non-negative whatever the signs of its cotangents.
/// With rotation nodes c and weights w_ic there is one rotation a node: what is said of R_i above counts for each R_c
/// that vertex i looks at, w_ic times. K and E_0 do not depend on them, since weights sum to 1.
///
/// @param stiffness     (n,) > 0, or empty: 1
/// @param meter         of the whole bind
/// @param choose_nodes  is called as soon as energy.K is there, before the cells: what needs only that may begin, and
///     read it until find_order returns. Without it cell i belongs to vertex i.
/// @param find_order    is called before the cells are written: which vertex becomes which, order[new] = old, and K and
///     the cells are numbered so. Null, or without it: all keep their numbers.
void assemble_surface_energy(CellEnergy& energy, const PolygonMesh& mesh, const Options& options,
                             const std::vector<double>& stiffness, int threads, const MeterPart& meter,
                             const std::function<RotationNodes()>& choose_nodes = {},
                             const std::function<const std::vector<int>*()>& find_order = {});

}  // namespace arap
