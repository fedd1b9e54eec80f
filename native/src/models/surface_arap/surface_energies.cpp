// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/surface_energies.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "arap/error.h"
#include "base/available_memory.h"
#include "base/grouped.h"
#include "mesh/triangulation.h"
#include "parallel/parallel.h"
#include "sparse/matrix_assembly.h"
#include "sparse/row_accumulator.h"
#include "sparse/sparse_rows.h"

namespace arap {

namespace {

/// Which items (triangles or ties) name a vertex.
class Incidence {
 public:
  template <class Item>
  Incidence(int n_vertices, const std::vector<Item>& all)
      : items_(n_vertices, [&](const auto& add) {
          for (size_t i = 0; i < all.size(); ++i)
            for (const int v : all[i].vertices) add(v, static_cast<int>(i));
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

class SurfaceAssembler {
 public:
  SurfaceAssembler(const PolygonMesh& mesh, const Options& options, const std::vector<double>& stiffness)
      : rest_(mesh.positions()),
        stiffness_(stiffness),
        is_spokes_(options.energy == Energy::kSpokes),
        triangulation_(triangulate(mesh, options.weights)),
        triangles_at_(mesh.n_vertices(), triangulation_.triangles),
        ties_at_(mesh.n_vertices(), triangulation_.ties) {
    if (!is_spokes_) return;
    for (Triangle& triangle : triangulation_.triangles)
      for (double& weight : triangle.half_cotangents) weight = std::max(0.0, weight);
  }

  [[nodiscard]] int n() const { return static_cast<int>(rest_.rows()); }

  /// Column i of K.
  void system_column(int i, RowAccumulator<double>& column) const {
    double diagonal = 0;
    triangles_at_.for_each(i, [&](int t) {
      const Triangle& triangle = triangulation_.triangles[t];
      for_edges_at(triangle, i, [&](size_t edge, int j) {
        const double value = 2 * triangle.half_cotangents[edge] * cells_of_edge(triangle, edge);
        diagonal += value;
        column[j] -= value;
      });
    });
    ties_at_.for_each(i, [&](int t) {
      const Tie& tie = triangulation_.ties[t];
      double own = 0;
      for (size_t a = 0; a < 3; ++a)
        if (tie.vertices[a] == i) own += tie.coefficients[a];
      const double factor = 2 * tie.weight * stiffness(tie.vertices[0]) * own;
      for (size_t a = 0; a < 3; ++a) column[tie.vertices[a]] += factor * tie.coefficients[a];
    });
    column[i] += diagonal;  // is always there, also of loose vertices
  }

  /// q at vertex j of the cells of all vertices, by vertex.
  void cells_at(int j, RowAccumulator<Vector3>& cells) const {
    triangles_at_.for_each(j, [&](int t) {
      const Triangle& triangle = triangulation_.triangles[t];
      Vector3 whole = Vector3::Zero();
      for_edges_at(triangle, j, [&](size_t edge, int other) {
        const Vector3 pull = triangle.half_cotangents[edge] * (rest_.row(j) - rest_.row(other)).transpose();
        whole += pull;
        if (!is_spokes_) return;
        cells[j] += scale(j) * pull;
        cells[other] += scale(other) * pull;
      });
      if (is_spokes_) return;
      for (const int i : triangle.vertices) cells[i] += scale(i) * whole;
    });
    ties_at_.for_each(j, [&](int t) {
      const Tie& tie = triangulation_.ties[t];
      Vector3 u = Vector3::Zero();
      for (size_t a = 0; a < 3; ++a) u += tie.coefficients[a] * rest_.row(tie.vertices[a]).transpose();
      const int i = tie.vertices[0];
      for (size_t a = 0; a < 3; ++a)
        if (tie.vertices[a] == j) cells[i] += 2 * stiffness(i) * tie.weight * tie.coefficients[a] * u;
    });
  }

 private:
  [[nodiscard]] double stiffness(int vertex) const { return stiffness_.empty() ? 1.0 : stiffness_[vertex]; }

  /// Of the edges of triangles in the cell of a vertex.
  [[nodiscard]] double scale(int vertex) const {
    const double whole = 2 * stiffness(vertex);
    return is_spokes_ ? whole : whole / 3;
  }

  /// Sum of the stiffnesses of the cells that contain an edge of a triangle, with the energy's factor.
  [[nodiscard]] double cells_of_edge(const Triangle& triangle, size_t edge) const {
    const double ends = stiffness(triangle.vertices[(edge + 1) % 3]) + stiffness(triangle.vertices[(edge + 2) % 3]);
    return is_spokes_ ? ends : (ends + stiffness(triangle.vertices[edge])) / 3;
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

  const Positions& rest_;
  const std::vector<double>& stiffness_;
  bool is_spokes_;
  Triangulation triangulation_;
  Incidence triangles_at_;
  Incidence ties_at_;
};

/// q of the cells of nodes: what the cells of vertices have, times the weights with which these look at the nodes.
Cells::Rows share_cells(const SurfaceAssembler& assembler, const RotationNodes& nodes, int threads,
                        const MeterPart& meter) {
  return {assembler.n(), nodes.size(), threads,
          [&] {
            return [&, cells = RowAccumulator<Vector3>(assembler.n())](int j, RowAccumulator<Vector3>& row) mutable {
              assembler.cells_at(j, cells);
              for (const auto& [i, q] : cells.entries())
                for (int e = nodes.offsets[i]; e < nodes.offsets[i + 1]; ++e)
                  row[nodes.nodes[e]] += nodes.weights[e] * q;
              cells.clear();
            };
          },
          meter};
}

}  // namespace

void assemble_surface_energy(CellEnergy& energy, const PolygonMesh& mesh, const Options& options,
                             const std::vector<double>& stiffness, int threads, const MeterPart& meter,
                             const std::function<RotationNodes()>& choose_nodes,
                             const std::function<const std::vector<int>*()>& find_order) {
  meter.tell();
  auto assembler = std::make_unique<const SurfaceAssembler>(mesh, options, stiffness);
  meter.add(0.1);
  meter.tell();
  energy.K = assemble_matrix(
      assembler->n(), threads, [&](int i, RowAccumulator<double>& column) { assembler->system_column(i, column); },
      meter.part(0.1));
  RotationNodes nodes = choose_nodes ? choose_nodes() : node_at_each_vertex(mesh.n_vertices());
  meter.tell();
  Cells::Rows cells = share_cells(*assembler, nodes, threads, meter.part(0.15));
  const std::vector<int> homes = std::move(nodes.vertices);
  // A large mesh needs the memory for what follows.
  assembler = nullptr;
  nodes = {};
  Positions K_rest;
  multiply(energy.K, mesh.positions(), K_rest, Workers(threads));
  energy.rest_energy = 0.5 * mesh.positions().cwiseProduct(K_rest).sum();
  K_rest.resize(0, 3);
  meter.tell();
  const std::vector<int>* order = find_order ? find_order() : nullptr;
  if (Cells::is_large(cells.offsets().back())) return_freed_memory();  // from here a bind needs the most
  take_cells(energy, std::move(cells), homes, order, threads, meter.part(0.05));
  meter.add(0.05);
  meter.tell();
}

}  // namespace arap
