// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/tet_arap/tet_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "base/grouped.h"
#include "mesh/tet_shape.h"
#include "parallel/parallel.h"
#include "sparse/matrix_assembly.h"

namespace arap {

namespace {

/// Of the vertices of a tetrahedron, row by row.
using Vectors = Eigen::Matrix<double, 4, 3>;

class TetAssembler {
 public:
  TetAssembler(const Positions& rest, const std::vector<TetMesh::Tet>& tets, const std::vector<double>& stiffness)
      : rest_(rest), tets_(tets), stiffness_(stiffness), slots_(n(), [&](const auto& add) {
          for (size_t t = 0; t < tets.size(); ++t)
            for (int k = 0; k < 4; ++k) add(tets[t][k], static_cast<int>(4 * t) + k);
        }) {
    for (int t = 0; t < n_tets(); ++t)
      if (weight(t) == 0 || !rest_vectors(t).allFinite())
        throw InvalidInput(text("tetrahedron ", t,
                                " is so small beside the mesh that nothing is left of it in rounding; enlarge or "
                                "remove it"));
  }

  /// Its volume times its stiffness.
  [[nodiscard]] double weight(int t) const {
    return std::abs(tet_edges(rest_, tets_[t]).determinant()) / 6 * stiffness(t);
  }
  [[nodiscard]] int n_tets() const { return static_cast<int>(tets_.size()); }

  [[nodiscard]] SparseMatrix system(int threads, const MeterPart& meter) const {
    const auto fill = [&](int i, RowAccumulator<double>& column) {
      double diagonal = 0;
      for (const int slot : slots_.of(i)) {
        const TetMesh::Tet& tet = tets_[slot / 4];
        const Eigen::Vector4d products = rest_vectors(slot / 4) * gradients(slot / 4).row(slot % 4).transpose();
        for (int k = 0; k < 4; ++k) {
          if (k == slot % 4) continue;
          column[tet[k]] += products[k];
          diagonal -= products[k];
        }
      }
      column[i] += diagonal;  // is always there, also of loose vertices
    };
    return assemble_matrix(n(), threads, fill, meter);
  }

  [[nodiscard]] Cells::Rows cells(int threads, const MeterPart& meter) const {
    return {n(), n_tets(), threads,
            [&] {
              return [&](int j, RowAccumulator<Vector3>& row) {
                for (const int slot : slots_.of(j)) row[slot / 4] += rest_vectors(slot / 4).row(slot % 4).transpose();
              };
            },
            meter};
  }

 private:
  [[nodiscard]] int n() const { return static_cast<int>(rest_.rows()); }

  [[nodiscard]] double stiffness(int t) const {
    if (stiffness_.empty()) return 1;
    double sum = 0;
    for (const int v : tets_[t]) sum += std::log(stiffness_[v]);
    return std::exp(sum / 4);
  }

  /// q_j = 2 V s g_j.
  [[nodiscard]] Vectors rest_vectors(int t) const { return 2 * weight(t) * gradients(t); }

  /// g_j.
  [[nodiscard]] Vectors gradients(int t) const {
    Vectors result;
    result.bottomRows<3>() = tet_edges(rest_, tets_[t]).inverse();
    result.row(0) = -result.bottomRows<3>().colwise().sum();
    return result;
  }

  const Positions& rest_;
  const std::vector<TetMesh::Tet>& tets_;
  const std::vector<double>& stiffness_;
  Grouped slots_;  ///< 4 * tetrahedron + corner, by vertex
};

/// A vertex outside of rigid regions; if there is none, of the region that has most vertices.
int choose_home(const TetMesh::Tet& tet, const std::vector<int>& region_of_vertex) {
  if (region_of_vertex.empty()) return tet[0];
  const auto of_same_region = [&](int v) {
    return std::count_if(tet.begin(), tet.end(), [&](int w) { return region_of_vertex[w] == region_of_vertex[v]; });
  };
  int home = tet[0];
  for (const int v : tet) {
    if (region_of_vertex[v] < 0) return v;
    if (of_same_region(v) > of_same_region(home)) home = v;
  }
  return home;
}

}  // namespace

void assemble_tet_energy(CellEnergy& energy, const Positions& rest, const std::vector<TetMesh::Tet>& tets,
                         const std::vector<double>& stiffness, const std::vector<int>& region_of_vertex, int threads,
                         const MeterPart& meter, const std::function<const std::vector<int>*()>& find_order) {
  const TetAssembler assembler(rest, tets, stiffness);
  meter.tell();
  energy.rest_energy = 0;
  for (int t = 0; t < assembler.n_tets(); ++t) energy.rest_energy += 3 * assembler.weight(t);
  energy.K = assembler.system(threads, meter.part(0.3));
  Cells::Rows cells = assembler.cells(threads, meter.part(0.5));
  std::vector<int> homes;
  homes.reserve(tets.size());
  for (const TetMesh::Tet& tet : tets) homes.push_back(choose_home(tet, region_of_vertex));
  take_cells(energy, std::move(cells), homes, find_order(), threads, meter.part(0.2));
}

std::vector<int> prepare_tets(PreparedModel& model, const TetMesh& mesh, const TetOptions& options,
                              const VertexProperties& properties, const Progress& progress) {
  Meter meter(progress, "binding was cancelled");
  model.part_of_vertex = mesh.part_of_vertex();
  model.n_parts = mesh.n_parts();
  model.workers = Workers(choose_threads(options.threads, mesh.n_vertices()));
  model.solver_factory = options.solver_factory;
  const std::vector<int> regions = without_single_vertices(properties.rigid_regions);
  model.regions = RigidRegions(regions, model.energy, model.rest);
  const auto find_order = [&] {
    model.choose_precision();
    model.solver = model.make_solver({&meter, 0.5});
    return model.solver->ordering();
  };
  assemble_tet_energy(model.energy, model.rest, mesh.tets(), properties.stiffness, regions, model.workers.threads(),
                      {&meter, 0.5}, find_order);
  std::vector<int> new_numbers = model.take_solver_numbers({&meter, 0});
  meter.reach(1);
  return new_numbers;
}

}  // namespace arap
