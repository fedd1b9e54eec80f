// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/types.h"
#include "parallel/meter.h"
#include "sparse/sparse.h"

namespace arap {

template <class Value>
class SparseRows;

/// The one form of every as-rigid-as-possible energy:
///
///     E(p', R) = 1/2 <p', K p'> - sum_c <R_c, Q_c(p')> + E_0,   Q_c(p') = sum_{j in c} p'_j q_cj^T,
///
/// with one rotation R_c a cell, K (n, n) symmetric positive semi-definite and rest vectors q_cj with
/// sum_j q_cj = 0. A model is a function that fills this in; everything after knows only this.
struct CellEnergy {
  SparseMatrix K;
  std::vector<int> cell_offsets;       ///< n_cells + 1: incidences of cell c are [offset c, offset c + 1)
  std::vector<int> cell_vertices;      ///< vertex j of each incidence
  Positions q;                         ///< q_cj of each incidence
  double rest_energy = 0;              ///< E_0
  std::vector<int> vertex_offsets;     ///< n + 1: the same incidences, by vertex
  std::vector<int> vertex_incidences;  ///< index into cell_vertices and q
  std::vector<int> vertex_cells;       ///< cell of each

  [[nodiscard]] int n_vertices() const { return static_cast<int>(K.rows()); }
  [[nodiscard]] int n_cells() const { return static_cast<int>(cell_offsets.size()) - 1; }

  /// The cell's reference vertex, its first: it decides the cell's rigid region and its place in the ordering. A cell
  /// of vertices that are alike should have one outside of rigid regions. -1 if the cell is empty.
  [[nodiscard]] int home(int cell) const {
    return cell_offsets[cell] < cell_offsets[cell + 1] ? cell_vertices[cell_offsets[cell]] : -1;
  }

  /// Fills in all but K and the rest energy.
  /// @param rows        q_cj by vertex j and cell c
  /// @param homes       the first vertex of each cell, where the cell has any
  /// @param new_of_old  (n,) the numbers that the vertices of rows get; cells are then numbered as their homes are.
  ///                    Empty: all keep theirs
  void set_cells(SparseRows<Vector3> rows, const std::vector<int>& homes, const std::vector<int>& new_of_old = {},
                 const MeterPart& meter = {});
};

}  // namespace arap
