// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "energy/cells.h"
#include "parallel/meter.h"
#include "sparse/sparse.h"

namespace arap {

/// The one form of every as-rigid-as-possible energy:
///
///     E(p', R) = 1/2 <p', K p'> - sum_c <R_c, Q_c(p')> + E_0,   Q_c(p') = sum_{j in c} p'_j q_cj^T,
///
/// with one rotation R_c a cell, K (n, n) symmetric positive semi-definite and rest vectors q_cj with
/// sum_j q_cj = 0. A model is a function that fills this in; everything after knows only this.
///
/// If the cells are of a solid, Q_c = 2 V_c F_c with V_c the volume of a cell and F_c its mean deformation gradient.
/// Then the same Q_c can keep volumes: the energy has a further term, k sum_c V_c (det F_c - 1)^2.
struct CellEnergy {
  SparseMatrix K;
  Cells cells;
  double rest_energy = 0;       ///< E_0
  double volume_stiffness = 0;  ///< k

  [[nodiscard]] int n_vertices() const { return static_cast<int>(K.rows()); }
  [[nodiscard]] int n_cells() const { return cells.size(); }
};

/// Gives an energy, whose K is there, its cells, and numbers both as a solver wants them.
/// @param rows   q_cj by vertex j and cell c
/// @param homes  of the cells
/// @param order  order[new] = old; null: all keep their numbers
void take_cells(CellEnergy& energy, Cells::Rows rows, const std::vector<int>& homes, const std::vector<int>* order,
                int threads, const MeterPart& meter);

}  // namespace arap
