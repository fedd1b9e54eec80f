// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface_model.h"

#include <numeric>
#include <utility>

#include "parallel.h"
#include "permutation.h"
#include "surface_energies.h"
#include "union_find.h"

namespace arap {

namespace {

/// Numbers the model's vertices anew; returns the number of each.
std::vector<int> renumber(BoundModel& model, const std::vector<int>& order) {
  std::vector<int> new_of_old = inverse_permutation(order);
  model.energy = renumbered(model.energy, order, order, model.threads);
  model.rest = Positions(model.rest(order, Eigen::all));
  std::vector<int> part_of_vertex;
  part_of_vertex.reserve(order.size());
  for (const int v : order) part_of_vertex.push_back(model.part_of_vertex[v]);
  model.part_of_vertex = std::move(part_of_vertex);
  model.regions.renumber(new_of_old);
  model.system_matrix = model.regions.reduce(model.energy.K);
  model.components = connected_components(model.system_matrix);
  model.solver->renumber(model.system_matrix);
  return new_of_old;
}

}  // namespace

std::vector<int> bind_surface(BoundModel& model, const PolygonMesh& mesh, const Options& options,
                              const std::vector<double>& stiffness, const std::vector<int>& region_of_vertex,
                              const Progress& progress) {
  model.rest = mesh.positions();
  model.part_of_vertex = mesh.part_of_vertex();
  model.n_parts = mesh.n_parts();
  model.threads = choose_threads(options.threads, mesh.n_vertices());
  model.energy = assemble_surface_energy(mesh, options, stiffness, model.threads, progress);
  // In a sum over few cells single precision shows, and there is no time to win.
  constexpr int kFewVertices = 2000;
  model.fits_single = mesh.n_vertices() >= kFewVertices && fits_single_precision(model.energy, model.rest);
  model.regions = RigidRegions(region_of_vertex, model.energy, model.rest);
  model.system_matrix = model.regions.reduce(model.energy.K);
  model.linear_solver = options.linear_solver;
  model.solver = make_linear_solver(model.system_matrix, model.linear_solver, model.threads);
  if (const std::vector<int>* order = model.solver->order(); order != nullptr)
    return renumber(model, std::vector<int>(*order));
  model.components = connected_components(model.system_matrix);
  std::vector<int> unchanged(mesh.n_vertices());
  std::iota(unchanged.begin(), unchanged.end(), 0);
  return unchanged;
}

}  // namespace arap
