// SPDX-License-Identifier: GPL-3.0-or-later
// Compares linear solvers on one matrix: the Laplacian of a torus with a tenth of its rows erased.
#include <benchmark/benchmark.h>
#include <omp.h>

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "base/eigen_compat.h"
#include "bumpy_torus.h"
#include "cholesky/block_ldlt.h"
#include "cholesky/multifrontal.h"
#include "cholesky/references/eigen_solvers.h"

namespace {

using arap::Isa;
using arap::LinearSolver;
using arap::Positions;
using arap::SparseMatrix;

/// Uniform weights on the edges of the torus and one diagonal of each quad: the pattern of a triangle mesh.
struct Problem {
  explicit Problem(int n_vertices) {
    const arap::bench::BumpyTorus torus(n_vertices);
    const int n = torus.n_around * torus.n_across;
    std::vector<Eigen::Triplet<double>> entries;
    for (int ring = 0; ring < torus.n_around; ++ring) {
      for (int k = 0; k < torus.n_across; ++k) {
        const int v = ring * torus.n_across + k;
        for (const auto& [dr, dk] : {std::array{0, 1}, std::array{1, 0}, std::array{1, 1}}) {
          const int w = (ring + dr) % torus.n_around * torus.n_across + (k + dk) % torus.n_across;
          entries.emplace_back(v, w, -1);
          entries.emplace_back(w, v, -1);
          entries.emplace_back(v, v, 1);
          entries.emplace_back(w, w, 1);
        }
      }
    }
    A.resize(n, n);
    A.setFromTriplets(entries.begin(), entries.end());
    is_erased.assign(static_cast<size_t>(n), 0);
    std::fill_n(is_erased.begin(), n / 10, 1);
    b = torus.positions;
  }

  void renumber(const std::vector<int>& order) {
    Eigen::PermutationMatrix<Eigen::Dynamic> to_new(A.rows());
    std::vector<char> is_erased_now;
    is_erased_now.reserve(order.size());
    for (size_t k = 0; k < order.size(); ++k) {
      to_new.indices()[order[k]] = static_cast<int>(k);
      is_erased_now.push_back(is_erased[order[k]]);
    }
    SparseMatrix B;
    B = A.twistedBy(to_new);
    A.swap(B);
    is_erased = is_erased_now;
    b = Positions(b(order, arap::all));
  }

  SparseMatrix A;
  std::vector<char> is_erased;
  Positions b;
};

const Problem& problem(int n_vertices) {
  static Problem current(1000);
  static int n_current = 1000;
  if (n_current != n_vertices) current = Problem(n_vertices);
  n_current = n_vertices;
  return current;
}

/// Arguments: vertices, threads, instruction set.
std::unique_ptr<LinearSolver> make_block(const benchmark::State& state) {
  return std::make_unique<arap::BlockLdlt>(problem(static_cast<int>(state.range(0))).A,
                                           arap::Workers(static_cast<int>(state.range(1))),
                                           static_cast<Isa>(state.range(2)));
}

std::unique_ptr<LinearSolver> make_simplicial(const benchmark::State& /*state*/) {
  return arap::make_eigen_solver(arap::LinearSolverKind::kSimplicialLdlt);
}

template <class Make>
void factorize(benchmark::State& state, const Make& make) {
  const Problem& p = problem(static_cast<int>(state.range(0)));
  const auto solver = make(state);
  for (auto _ : state) benchmark::DoNotOptimize(solver->factorize(p.A, p.is_erased));
}

/// In the solver's ordering, as models use it.
template <class Make>
void solve(benchmark::State& state, const Make& make) {
  Problem p = problem(static_cast<int>(state.range(0)));
  const auto solver = make(state);
  if (const std::vector<int>* order = solver->ordering()) {
    p.renumber(std::vector<int>(*order));
    solver->renumber(p.A);
  }
  const auto factor = solver->factorize(p.A, p.is_erased);
  Positions x = p.b;
  for (auto _ : state) {
    factor->solve(x);
    x = p.b;
  }
}

void bind_block_ldlt(benchmark::State& state) {
  problem(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(make_block(state));
  const auto solver = make_block(state);
  const auto& plan = dynamic_cast<const arap::BlockLdlt&>(*solver).plan();
  state.counters["factor_MB"] = static_cast<double>(plan.tile_offsets.back()) * 64e-6;
  state.counters["supernodes"] = static_cast<double>(plan.structure.supernodes.size());
}

void sizes(benchmark::internal::Benchmark* b) {
  b->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int n : {1'000, 10'000, 100'000, 1'000'000}) b->Args({n});
}

void sizes_threads_isas(benchmark::internal::Benchmark* b) {
  b->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int n : {1'000, 10'000, 100'000, 1'000'000})
    for (int threads = 1; threads <= omp_get_max_threads(); ++threads)
      for (const Isa isa : arap::available_isas()) b->Args({n, threads, static_cast<int>(isa)});
}

BENCHMARK_CAPTURE(factorize, simplicial_ldlt, make_simplicial)->Apply(sizes);
BENCHMARK_CAPTURE(factorize, block_ldlt, make_block)->Apply(sizes_threads_isas);
BENCHMARK_CAPTURE(solve, simplicial_ldlt, make_simplicial)->Apply(sizes);
BENCHMARK_CAPTURE(solve, block_ldlt, make_block)->Apply(sizes_threads_isas);
BENCHMARK(bind_block_ldlt)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->ArgsProduct({{1'000, 10'000, 100'000, 1'000'000}, {1}, {0}});

}  // namespace
