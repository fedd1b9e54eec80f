// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
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

  /// use(vertices, i, q) for what each triangle and tie adds to that in the cell of vertex i; not for spokes, whose
  /// cells have edges.
  template <class Use>
  void for_each_term(int j, const Use& use) const;

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

  /// f(edge, other end) for the two edges of the triangle at vertex i.
  template <class Function>
  static void for_edges_at(const Triangle& triangle, int i, const Function& f) {
    for (size_t edge = 0; edge < 3; ++edge) {
      const int a = triangle.vertices[(edge + 1) % 3];
      const int b = triangle.vertices[(edge + 2) % 3];
      if (a == i) f(edge, b);
      if (b == i) f(edge, a);
    }
  }

  template <class Use>
  void for_each_tie_term(int j, const Use& use) const;

  /// Sum of the stiffnesses of the cells that contain an edge of a triangle, with the energy's factor.
  [[nodiscard]] double cells_of_edge(const Triangle& triangle, size_t edge) const;

  const Positions& rest_;
  const std::vector<double>& stiffness_;
  bool is_spokes_;
  Triangulation triangulation_;
  Incidence triangles_at_;
  Incidence ties_at_;
};

template <class Use>
void SurfaceAssembler::for_each_term(int j, const Use& use) const {
  triangles_at_.for_each(j, [&](int t) {
    const Triangle& triangle = triangulation_.triangles[t];
    Vector3 whole = Vector3::Zero();
    for_edges_at(triangle, j, [&](size_t edge, int other) {
      whole += triangle.half_cotangents[edge] * (rest_.row(j) - rest_.row(other)).transpose();
    });
    for (const int i : triangle.vertices) use(triangle.vertices, i, Vector3(scale(i) * whole));
  });
  for_each_tie_term(j, use);
}

template <class Use>
void SurfaceAssembler::for_each_tie_term(int j, const Use& use) const {
  ties_at_.for_each(j, [&](int t) {
    const Tie& tie = triangulation_.ties[t];
    Vector3 u = Vector3::Zero();
    for (size_t a = 0; a < 3; ++a) u += tie.coefficients[a] * rest_.row(tie.vertices[a]).transpose();
    const int i = tie.vertices[0];
    for (size_t a = 0; a < 3; ++a)
      if (tie.vertices[a] == j) use(tie.vertices, i, Vector3(2 * stiffness(i) * tie.weight * tie.coefficients[a] * u));
  });
}

}  // namespace arap
