// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/surface_energies.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "arap/error.h"
#include "base/available_memory.h"
#include "models/surface_arap/surface_assembler.h"
#include "parallel/parallel.h"
#include "sparse/matrix_assembly.h"
#include "sparse/row_accumulator.h"
#include "sparse/sparse_rows.h"

namespace arap {

namespace {

/// q of the cells of nodes: what the cells of vertices have, times the weights with which these look at the nodes.
Cells::Rows share_cells(const SurfaceAssembler& assembler, const RotationNodes& nodes, int threads,
                        const MeterPart& meter) {
  std::vector<int> node_of_vertex(assembler.n(), -1);
  for (int c = 0; c < nodes.size(); ++c) node_of_vertex[nodes.vertices[c]] = c;
  return {assembler.n(), nodes.size(), threads,
          [&] {
            return [&, cells = RowAccumulator<Vector3>(assembler.n())](int j, RowAccumulator<Vector3>& row) mutable {
              assembler.cells_at(j, cells);
              for (const auto& [i, q] : cells.entries())
                for (int e = nodes.offsets[i]; e < nodes.offsets[i + 1]; ++e)
                  row[nodes.nodes[e]] += nodes.weights[e] * q;
              cells.clear();
              // Its vertex is the home of its cell, whatever weight it has.
              if (const int own = node_of_vertex[j]; own >= 0 && !row.entries().empty()) static_cast<void>(row[own]);
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
