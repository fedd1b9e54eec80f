// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/surface_model.h"

#include <future>
#include <memory>

#include "base/permutation.h"
#include "mesh/mirror_symmetry.h"
#include "mesh/thickness_links.h"
#include "models/surface_arap/surface_energies.h"
#include "models/surface_arap/surface_terms.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "sampling/rotation_nodes.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

/// Which vertices are nodes, and the weights of all with them.
RotationNodes choose_nodes(const SurfaceModel& model, const PolygonMesh& mesh, double radius,
                           const std::vector<int>& region_of_vertex, const MeterPart& meter) {
  const PreparedModel& prepared = model.prepared;
  const int threads = prepared.workers.threads();
  const std::vector<std::vector<int>> mirrors = find_mirrors(mesh, threads, meter.part(0.05));
  meter.tell();
  const auto links = find_thickness_links(mesh, radius, mirrors, threads, meter.part(0.05));
  meter.tell();
  const EdgeGraph graph(prepared.energy.K, prepared.rest, threads, links);
  meter.tell();
  return choose_rotation_nodes(graph, mesh, model.areas, radius, mirrors, region_of_vertex, threads, meter.part(0.15));
}

}  // namespace

std::vector<int> prepare_surface(SurfaceModel& model, const PolygonMesh& mesh, const Options& options,
                                 const std::vector<double>& stiffness, const std::vector<int>& region_of_vertex,
                                 const Progress& progress) {
  Meter meter(progress, "binding was cancelled");
  PreparedModel& prepared = model.prepared;
  model.areas = vertex_areas(mesh);
  prepared.rest = mesh.positions();
  prepared.part_of_vertex = mesh.part_of_vertex();
  prepared.n_parts = mesh.n_parts();
  prepared.workers = Workers(choose_threads(options.threads, mesh.n_vertices()));
  prepared.solver_factory = options.solver_factory;
  const std::vector<int> regions = without_single_vertices(region_of_vertex);
  prepared.regions = RigidRegions(regions, prepared.energy, prepared.rest);
  // The order of the unknowns takes a good part of a bind: the cells are made beside it.
  std::future<std::unique_ptr<LinearSolver>> solver;
  RotationNodes nodes;
  const auto with_matrix = [&] {
    solver = beside(prepared.workers, [&] { return prepared.make_solver({&meter, 0.25}); });
    if (options.energy != Energy::kRotationNodes) return node_at_each_vertex(mesh.n_vertices());
    nodes = choose_nodes(model, mesh, options.rigidity_radius, regions, {&meter, 1});
    return nodes;
  };
  const auto find_order = [&] {
    prepared.choose_precision();
    meter.wait_for(solver);
    prepared.solver = solver.get();
    return prepared.solver->ordering();
  };
  assemble_surface_energy(prepared.energy, mesh, options, stiffness, prepared.workers.threads(), {&meter, 1},
                          with_matrix, find_order);
  if (const std::vector<int>* order = prepared.solver->ordering(); order != nullptr)
    model.areas = permuted(model.areas, *order);
  std::vector<int> new_numbers = prepared.take_solver_numbers({&meter, 0});
  if (options.energy == Energy::kRotationNodes)
    prepared.terms = std::make_unique<SurfaceTerms>(mesh, options, stiffness, std::move(nodes), new_numbers);
  meter.reach(1);
  return new_numbers;
}

}  // namespace arap
