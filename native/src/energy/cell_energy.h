// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "energy/cells.h"
#include "energy/cube_cells.h"
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
///
/// Cells are listed, or made of cubes.
struct CellEnergy {
  SparseMatrix K;
  Cells cells;
  CubeCells cubes;
  double rest_energy = 0;       ///< E_0
  double volume_stiffness = 0;  ///< k

  [[nodiscard]] int n_vertices() const { return static_cast<int>(K.rows()); }
  [[nodiscard]] int n_cells() const { return n_cells(cells); }
  /// With listed cells that stand for `cells`.
  [[nodiscard]] int n_cells(const Cells& listed) const { return cubes.empty() ? listed.size() : cubes.size(); }
  /// See Cells::home().
  [[nodiscard]] int home(const Cells& listed, int cell) const { return cubes.empty() ? listed.home(cell) : cell; }
  /// Whether memory decides what stays.
  [[nodiscard]] bool is_large() const {
    return Cells::is_large(cubes.empty() ? cells.n_incidences() : cubes.slots().size());
  }
};

/// Gives an energy, whose K is there, its cells, and numbers both as a solver wants them.
/// @param rows   q_cj by vertex j and cell c
/// @param homes  of the cells
/// @param order  order[new] = old; null: all keep their numbers
void take_cells(CellEnergy& energy, Cells::Rows rows, const std::vector<int>& homes, const std::vector<int>* order,
                int threads, const MeterPart& meter);
/// The same for cells made of cubes.
void take_cubes(CellEnergy& energy, CubeCells cubes, const std::vector<int>* order, int threads);

}  // namespace arap
