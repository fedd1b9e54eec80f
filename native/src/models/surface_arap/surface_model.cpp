// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/surface_model.h"

#include <future>
#include <map>
#include <memory>
#include <numeric>

#include "base/eigen_compat.h"
#include "base/permutation.h"
#include "cholesky/solver_choice.h"
#include "mesh/mirror_symmetry.h"
#include "mesh/thickness_links.h"
#include "models/surface_arap/surface_energies.h"
#include "parallel/parallel.h"
#include "sampling/rotation_nodes.h"
#include "sampling/surface_patch.h"
#include "sparse/connected_components.h"

namespace arap {

namespace {

/// The regions but for those of one vertex: that is no more rigid than it is alone, and wants no node of its own.
std::vector<int> without_single_vertices(std::vector<int> region_of_vertex) {
  std::map<int, int> n_members;
  for (const int region : region_of_vertex) ++n_members[region];
  for (int& region : region_of_vertex)
    if (n_members[region] == 1) region = -1;
  return region_of_vertex;
}

/// Which vertices are nodes, and the weights of all with them.
RotationNodes choose_nodes(const BoundModel& model, const PolygonMesh& mesh, double radius,
                           const std::vector<int>& region_of_vertex) {
  const std::vector<std::vector<int>> mirrors = find_mirrors(mesh, model.workers.threads());
  const EdgeGraph graph(model.energy.K, model.rest, model.workers.threads(),
                           find_thickness_links(mesh, radius, mirrors, model.workers.threads()));
  return choose_rotation_nodes(graph, mesh, model.areas, radius, mirrors, region_of_vertex, model.workers.threads());
}

template <class Value>
std::vector<Value> in_order(const std::vector<Value>& values, const std::vector<int>& order) {
  std::vector<Value> result;
  result.reserve(order.size());
  for (const int v : order) result.push_back(values[v]);
  return result;
}

/// act(), beside what else there is to do where there are threads for it; else when it is asked for.
template <class Act>
auto beside(const Workers& workers, const Act& act) {
  return std::async(workers.threads() > 1 ? std::launch::async : std::launch::deferred, act);
}

/// Follows the energy, whose vertices have new numbers; returns the number of each.
std::vector<int> renumber(BoundModel& model, const std::vector<int>& order) {
  std::vector<int> new_of_old = inverse_permutation(order);
  model.regions.renumber(new_of_old);
  model.reduce_matrix();
  std::future<void> solver = beside(model.workers, [&] { model.solver->renumber(model.system_matrix()); });
  model.components = connected_components(model.system_matrix());
  model.rest = Positions(model.rest(order, all));
  model.part_of_vertex = in_order(model.part_of_vertex, order);
  model.areas = in_order(model.areas, order);
  model.regions.read_cells();
  solver.get();
  return new_of_old;
}

/// Where nothing gets another number.
std::vector<int> keep_numbers(BoundModel& model) {
  model.components = connected_components(model.system_matrix());
  model.regions.read_cells();
  std::vector<int> unchanged(model.rest.rows());
  std::iota(unchanged.begin(), unchanged.end(), 0);
  return unchanged;
}

}  // namespace

std::vector<int> bind_surface(BoundModel& model, const PolygonMesh& mesh, const Options& options,
                              const std::vector<double>& stiffness, const std::vector<int>& region_of_vertex,
                              const Progress& progress) {
  model.rest = mesh.positions();
  model.part_of_vertex = mesh.part_of_vertex();
  model.areas = vertex_areas(mesh);
  model.n_parts = mesh.n_parts();
  model.workers = Workers(choose_threads(options.threads, mesh.n_vertices()));
  model.linear_solver = options.linear_solver;
  const std::vector<int> regions = without_single_vertices(region_of_vertex);
  model.regions = RigidRegions(regions, model.energy, model.rest);
  // The order of the unknowns takes a good part of a bind: the cells are made beside it.
  std::future<std::unique_ptr<LinearSolver>> solver;
  const auto with_matrix = [&] {
    model.reduce_matrix();
    solver = beside(model.workers,
                    [&model] { return make_linear_solver(model.system_matrix(), model.linear_solver, model.workers); });
    return options.energy == Energy::kRotationNodes ? choose_nodes(model, mesh, options.rigidity_radius, regions)
                                                    : node_at_each_vertex(mesh.n_vertices());
  };
  const auto find_order = [&] {
    // In a sum over few cells single precision shows, and there is no time to win.
    constexpr int kFewVertices = 2000;
    model.fits_single = mesh.n_vertices() >= kFewVertices && fits_single_precision(model.energy, model.rest);
    model.solver = solver.get();
    return model.solver->order();
  };
  assemble_surface_energy(model.energy, mesh, options, stiffness, model.workers.threads(), progress, with_matrix,
                          find_order);
  const std::vector<int>* order = model.solver->order();
  return order == nullptr ? keep_numbers(model) : renumber(model, std::vector<int>(*order));
}

}  // namespace arap
