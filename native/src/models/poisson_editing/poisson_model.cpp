// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/poisson_editing/poisson_model.h"

#include <future>
#include <memory>

#include "base/permutation.h"
#include "models/surface_arap/surface_assembler.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "sparse/matrix_assembly.h"

namespace arap {

std::vector<int> prepare_poisson(PoissonModel& model, const PolygonMesh& mesh, const PoissonOptions& options,
                                 const Progress& progress) {
  Meter meter(progress, "binding was cancelled");
  meter.tell();
  PreparedModel& prepared = model.prepared;
  prepared.rest = mesh.positions();
  prepared.part_of_vertex = mesh.part_of_vertex();
  prepared.n_parts = mesh.n_parts();
  prepared.workers = Workers(choose_threads(options.threads, mesh.n_vertices()));
  const int threads = prepared.workers.threads();
  Options of_surface;
  of_surface.energy = Energy::kSpokesAndRims;
  const std::vector<double> no_stiffness;
  const SurfaceAssembler assembler(mesh, of_surface, no_stiffness);
  meter.tell();
  const auto fill = [&](int i, RowAccumulator<double>& column) { assembler.system_column(i, column); };
  prepared.energy.K = assemble_matrix(mesh.n_vertices(), threads, fill, {&meter, 0.2});
  // The order of the unknowns takes most of a bind: the rest vectors are made beside it.
  std::future<std::unique_ptr<LinearSolver>> solver = beside(prepared.workers, [&] {
    return prepared.make_solver({&meter, 0.6});
  });
  model.forces = FaceForces(mesh, assembler.triangulation());
  meter.wait_for(solver);
  prepared.solver = solver.get();
  if (const std::vector<int>* order = prepared.solver->ordering(); order != nullptr)
    prepared.energy.K = renumbered(prepared.energy.K, *order, inverse_permutation(*order), threads);
  std::vector<int> new_numbers = prepared.take_solver_numbers({&meter, 0});
  model.forces.renumber(new_numbers);
  meter.reach(1);
  return new_numbers;
}

}  // namespace arap
