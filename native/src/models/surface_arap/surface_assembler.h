// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "arap/options.h"
#include "base/grouped.h"
#include "mesh/triangulation.h"
#include "sparse/row_accumulator.h"

namespace arap {

/// What the triangles and ties of a surface put into its matrix and its cells, vertex by vertex; the energies are those
/// of assemble_surface_energy().
class SurfaceAssembler {
 public:
  /// @param mesh, stiffness  as there; must outlive the assembler
  SurfaceAssembler(const PolygonMesh& mesh, const Options& options, const std::vector<double>& stiffness);

  [[nodiscard]] int n() const { return static_cast<int>(rest_.rows()); }
  [[nodiscard]] const Triangulation& triangulation() const { return triangulation_; }

  /// Column i of K.
  void system_column(int i, RowAccumulator<double>& column) const;

  /// q at vertex j of the cells of all vertices, by vertex.
  void cells_at(int j, RowAccumulator<Vector3>& cells) const;

 private:
  /// Which items (triangles or ties) name a vertex.
  class Incidence {
   public:
    template <class Item>
    Incidence(int n_vertices, const std::vector<Item>& items)
        : items_(n_vertices, [&](const auto& add) {
            for (size_t i = 0; i < items.size(); ++i)
              for (const int v : items[i].vertices) add(v, static_cast<int>(i));
          }) {}

    /// f(item) for each item of v once; a tie that names v twice lists it twice in a row.
    template <class Function>
    void for_each(int v, const Function& f) const {
      int last = -1;
      for (const int item : items_.of(v)) {
        if (item != last) f(item);
        last = item;
      }
    }

   private:
    Grouped items_;
  };

  [[nodiscard]] double stiffness(int vertex) const { return stiffness_.empty() ? 1.0 : stiffness_[vertex]; }

  /// Of the edges of triangles in the cell of a vertex.
  [[nodiscard]] double scale(int vertex) const {
    const double whole = 2 * stiffness(vertex);
    return is_spokes_ ? whole : whole / 3;
  }

  /// Sum of the stiffnesses of the cells that contain an edge of a triangle, with the energy's factor.
  [[nodiscard]] double cells_of_edge(const Triangle& triangle, size_t edge) const;

  const Positions& rest_;
  const std::vector<double>& stiffness_;
  bool is_spokes_;
  Triangulation triangulation_;
  Incidence triangles_at_;
  Incidence ties_at_;
};

}  // namespace arap
