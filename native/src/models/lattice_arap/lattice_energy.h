// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "energy/cell_energy.h"
#include "lattice/lattice.h"
#include "parallel/meter.h"

namespace arap {

/// Fills in the energy of what a lattice has inside. The deformation gradient F_e of piece e, of volume V_e, is the
/// mean over the eight octants of its cube, each trilinear between its eight control points; M_j are these weights.
/// With the B-spline weights w_en = (1/6, 2/3, 1/6)^3 of the 27 control points n of a piece, one rotation R_n a control
/// point:
///
///     E = sum_e V_e [ mean over octants |F|^2 - 2 <F_e, sum_n w_en R_n> + 3 ]
///
/// so K = 2 sum_e V_e mean grad M grad M^T and q_nj = 2 sum_e V_e w_en mean grad M_j. With stiffness s_e it counts s_e
/// times. Trilinear octants instead of the B-spline's own gradients: 21 entries a row of K instead of 125, and less
/// stiff.
///
/// @param stiffness   (n_pieces,) or empty: all 1
/// @param find_order  is called when K is there: which control point becomes which, order[new] = old, and K and the
/// cells
///     are numbered so. Null: all keep their numbers.
void assemble_lattice_energy(CellEnergy& energy, const Lattice& lattice, const std::vector<double>& stiffness,
                             int threads, const MeterPart& meter,
                             const std::function<const std::vector<int>*()>& find_order);

}  // namespace arap
