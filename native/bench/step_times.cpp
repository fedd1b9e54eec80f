// SPDX-License-Identifier: GPL-3.0-or-later
// The one file of the benchmarks that knows the library's insides: the public interface has no part of an iteration.
#include "step_times.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include "block_ldlt.h"
#include "bound_constraints.h"
#include "cell_passes.h"
#include "parallel.h"
#include "process.h"
#include "surface_energies.h"

namespace arap::bench {

namespace {

constexpr int kWarmUp = 3;
constexpr int kSamples = 15;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <class Act>
double timed_ms(const Act& act) {
  const Stopwatch watch;
  act();
  return watch.ms();
}

void bind(const TaskFile& task, const Options& options, BoundModel& model) {
  // Of size 1, as SurfaceArap has it.
  const PolygonMesh mesh(task.positions / task.mesh().diagonal(), task.corner_vertices, task.face_sizes);
  model.rest = mesh.positions();
  model.part_of_vertex = mesh.part_of_vertex();
  model.n_parts = mesh.n_parts();
  model.threads = choose_threads(options.threads, mesh.n_vertices());
  model.energy = assemble_surface_energy(mesh, options, {}, model.threads, {});
  model.passes = std::make_unique<CellPasses>(model.energy, model.threads);
  model.regions = RigidRegions({}, model.energy, model.rest);
  model.system_matrix = model.regions.reduce(model.energy.K);
  model.linear_solver = options.linear_solver;
  model.solver = make_linear_solver(model.system_matrix, model.linear_solver, model.threads);
}

std::int64_t factor_bytes(const LinearSolver& solver) {
  const auto* block_ldlt = dynamic_cast<const BlockLdlt*>(&solver);
  constexpr std::int64_t kTileBytes = 64;
  return block_ldlt == nullptr ? 0 : kTileBytes * block_ldlt->plan().tile_offsets.back();
}

}  // namespace

StepTimes time_steps(const TaskFile& task, const Options& options) {
  BoundModel model;
  bind(task, options, model);
  ConstraintSet set;
  set.vertices = task.constrained;
  set.strengths.assign(task.constrained.size(), 1.0);
  std::vector<int> model_vertex(model.rest.rows());
  std::iota(model_vertex.begin(), model_vertex.end(), 0);
  const BoundConstraints constraints(model, set, model_vertex, {});

  Positions positions = model.rest;
  const Positions targets = task.targets / task.mesh().diagonal();
  for (size_t k = 0; k < task.constrained.size(); ++k) positions.row(task.constrained[k]) = targets.row(k);
  Rotations rotations = identity_rotations(model.energy.n_cells());
  Positions residual;
  Positions multipliers(0, 3);
  std::vector<double> local;
  std::vector<double> global;
  std::vector<double> solve;
  for (int k = -kWarmUp; k < kSamples; ++k) {
    const double local_ms = timed_ms([&] {
      model.passes->set_positions(positions);
      model.passes->fit_rotations(rotations);
    });
    double solve_ms = 0;
    const double global_ms = timed_ms([&] {
      model.passes->find_residual(rotations, residual);
      solve_ms = timed_ms([&] { constraints.system().correct(residual, Positions(0, 3), multipliers); });
      positions += residual;
    });
    if (k < 0) continue;
    local.push_back(local_ms);
    global.push_back(global_ms);
    solve.push_back(solve_ms);
  }
  return {median(local), median(global), median(solve), factor_bytes(*model.solver)};
}

}  // namespace arap::bench
