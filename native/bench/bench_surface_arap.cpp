// SPDX-License-Identifier: GPL-3.0-or-later
// The three acts and their costs: bind a mesh, set constraints, iterate to new targets. A bumpy torus is held at a
// tenth of its rings; the tenth opposite is turned by 90 degrees about x and lifted.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <numbers>
#include <vector>

#include "arap/surface_arap.h"
#include "bumpy_torus.h"

namespace {

using arap::Positions;
using arap::bench::BumpyTorus;

/// Held rings and turned rings with their targets.
struct Task {
  explicit Task(const BumpyTorus& torus) {
    const int n_rings = std::max(1, torus.n_around / 10);
    constraints.vertices = torus.rings(0, n_rings);
    const std::vector<int> moved = torus.rings(torus.n_around / 2, n_rings);
    const size_t n_held = constraints.vertices.size();
    constraints.vertices.insert(constraints.vertices.end(), moved.begin(), moved.end());
    constraints.strengths.assign(constraints.vertices.size(), 1.0);

    const Eigen::AngleAxisd turn(std::numbers::pi / 2, arap::Vector3::UnitX());
    targets = torus.positions(constraints.vertices, Eigen::all);
    for (auto row = static_cast<Eigen::Index>(n_held); row < targets.rows(); ++row) {
      targets.row(row) = (turn * arap::Vector3(targets.row(row)) + arap::Vector3(0, 0, 0.5)).transpose();
    }
  }

  arap::ConstraintSet constraints;
  Positions targets;
};

void bind(benchmark::State& state) {
  const BumpyTorus torus(static_cast<int>(state.range(0)));
  const arap::PolygonMesh mesh = torus.mesh();
  for (auto _ : state) {
    arap::SurfaceArap model(mesh);
    benchmark::DoNotOptimize(model.n_parts());
  }
  state.counters["vertices"] = mesh.n_vertices();
}

void set_constraints(benchmark::State& state) {
  const BumpyTorus torus(static_cast<int>(state.range(0)));
  const Task task(torus);
  arap::SurfaceArap model(torus.mesh());
  // The same set again would cost nothing, so two sets take turns.
  arap::ConstraintSet other = task.constraints;
  other.vertices.pop_back();
  other.strengths.pop_back();
  bool is_other = false;
  for (auto _ : state) {
    model.set_constraints(is_other ? other : task.constraints);
    is_other = !is_other;
  }
  state.counters["vertices"] = model.n_vertices();
}

void iteration(benchmark::State& state) {
  const BumpyTorus torus(static_cast<int>(state.range(0)));
  const Task task(torus);
  arap::SurfaceArap model(torus.mesh());
  model.set_constraints(task.constraints);
  // Ten at a time, as a frame of a drag does it; reported is the time of one.
  constexpr int kIterations = 10;
  const arap::SolveOptions options{.max_iterations = kIterations, .energy_tolerance = 0, .step_tolerance = 0};
  arap::SolveResult result;
  for (auto _ : state) {
    model.reset();
    const auto start = std::chrono::steady_clock::now();
    result = model.solve(task.targets, options);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(elapsed.count() / kIterations);
  }
  state.counters["vertices"] = model.n_vertices();
  state.counters["threads"] = model.threads();
  state.counters["energy"] = result.energy_after;
}

BENCHMARK(bind)->Arg(1'000)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(set_constraints)->Arg(1'000)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(iteration)->Arg(1'000)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMillisecond)->UseManualTime();

}  // namespace
