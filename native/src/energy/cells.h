// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "base/aligned_buffer.h"
#include "energy/sliced_rows.h"
#include "parallel/meter.h"
#include "sparse/sparse_rows.h"

namespace arap {

/// Changes of cells.
struct CellChanges {
  /// A cell that gets vertices or loses some; all its vertices are among those below. The further ones come last.
  struct Cell {
    int number;
    int home;  ///< another one if the cell has not got it
  };
  /// A vertex, and all its cells.
  struct Vertex {
    int number;
    std::vector<std::pair<int, Vector3>> cells;
  };

  std::vector<Cell> cells;       ///< by number
  std::vector<Vertex> vertices;  ///< by number
};

/// The cells of an energy: rest vectors q_cj of vertices j in cells c, once by cell and once by vertex, as an iteration
/// reads them. Those of a cell sum to 0, so by cell there is none of its home.
class Cells {
 public:
  using Rows = SparseRows<Vector3, SplitVector>;

  Cells() = default;
  /// @param rows        q_cj by vertex j and cell c
  /// @param homes       the home of each cell, if the cell has any vertex
  /// @param new_of_old  (n,) the numbers that the vertices of rows get; cells are then numbered as their homes are.
  ///                    Empty: all keep theirs
  Cells(Rows rows, const std::vector<int>& homes, const std::vector<int>& new_of_old = {}, const MeterPart& meter = {});

  /// Those of another one with some changes.
  /// @param others   have all their rows themselves, and must outlive these
  /// @param changes  what is changed, and further cells
  Cells(const Cells& others, CellChanges changes, int threads, const MeterPart& meter = {});

  [[nodiscard]] int size() const { return static_cast<int>(n_others_.size()); }
  [[nodiscard]] size_t n_incidences() const { return n_incidences_; }
  /// Whether memory decides what stays.
  [[nodiscard]] static bool is_large(size_t n_incidences) { return n_incidences > 4'000'000; }

  /// The cell's reference vertex: it decides the cell's rigid region and its place in the ordering. A cell of vertices
  /// that are alike should have one outside of rigid regions. -1 if the cell is empty.
  [[nodiscard]] int home(int cell) const { return n_others_[cell] < 0 ? -1 : homes_[cell]; }

  /// f(vertex, q) for the vertices of a cell but its home.
  template <class Function>
  void for_each_vertex(int cell, const Function& f) const {
    for (int e = 0; e < n_others_[cell]; ++e) f(by_cell_.index(cell, e), by_cell_.vector(cell, e));
  }

  /// f(cell, q) for the cells of a vertex.
  template <class Function>
  void for_each_cell(int vertex, const Function& f) const {
    for (int e = 0; e < n_cells_[vertex]; ++e) f(by_vertex_.index(vertex, e), by_vertex_.vector(vertex, e));
  }

  [[nodiscard]] const SlicedVectors& by_cell() const { return by_cell_; }
  [[nodiscard]] const SlicedVectors& by_vertex() const { return by_vertex_; }
  /// Of each cell, 0 if it is empty; filled up to whole slices.
  [[nodiscard]] const int* homes() const { return homes_.data(); }

 private:
  std::vector<int> n_others_;  ///< vertices of each cell but its home; -1: not even that
  std::vector<int> n_cells_;   ///< of each vertex
  size_t n_incidences_ = 0;
  AlignedBuffer<int> homes_;
  SlicedVectors by_cell_;
  SlicedVectors by_vertex_;
};

}  // namespace arap
