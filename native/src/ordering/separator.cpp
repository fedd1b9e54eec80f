// SPDX-License-Identifier: GPL-3.0-or-later
#include "ordering/separator.h"

#include <algorithm>
#include <random>
#include <utility>

#include "ordering/multilevel_graph.h"
#include "ordering/separator_refinement.h"

namespace arap {

namespace {

/// A graph of so few vertices is not made coarser, but divided several times.
constexpr int kCoarsest = 100;
constexpr int kTries = 2;

/// Of large graphs the search is repeated where the graph has become this much smaller, and so is cheap.
constexpr int kLarge = 5000;
constexpr int kRuns = 6;
constexpr int kRunsShare = 32;

/// Most of the work is for many small graphs, most of what can be gained is in the few large ones.
int passes_for(const Graph& graph) { return graph.n_vertices() > 4000 ? 8 : 2; }

/// Side 0 grows from one vertex until it has half the weight; what it touches is between.
Separator grow(const Graph& graph, int seed) {
  const int n = graph.n_vertices();
  const int total = graph.total_weight();
  Separator separator{std::vector<Separator::Side>(n, 1), {0, total, 0}};
  std::vector<int> queue{seed};
  std::vector<char> is_queued(n, 0);
  is_queued[seed] = 1;
  int next_seed = 0;
  for (size_t k = 0; 2L * separator.weights[0] < total; ++k) {
    if (k == queue.size()) {  // another component
      while (is_queued[next_seed] != 0) ++next_seed;
      is_queued[next_seed] = 1;
      queue.push_back(next_seed);
    }
    const int v = queue[k];
    separator.side[v] = 0;
    separator.weights[0] += graph.weights[v];
    separator.weights[1] -= graph.weights[v];
    for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e) {
      const int u = graph.neighbours[e];
      if (is_queued[u] != 0) continue;
      is_queued[u] = 1;
      queue.push_back(u);
    }
  }
  for (const int v : queue) {
    if (separator.side[v] == 0) continue;
    // Queued only: it touches side 0, unless it is the seed of a component that was not needed.
    separator.side[v] = Separator::kBetween;
    separator.weights[1] -= graph.weights[v];
    separator.weights[2] += graph.weights[v];
  }
  return separator;
}

Separator best_grown(const Graph& graph, std::minstd_rand& random) {
  Separator best;
  for (int k = 0; k < kTries; ++k) {
    Separator separator = grow(graph, static_cast<int>(random() % static_cast<unsigned>(graph.n_vertices())));
    refine(graph, separator, 1);
    if (k == 0 || separator_cost(separator) < separator_cost(best)) best = std::move(separator);
  }
  return best;
}

Separator project(const Separator& coarse, const std::vector<int>& coarse_of) {
  Separator fine{std::vector<Separator::Side>(coarse_of.size()), coarse.weights};
  for (size_t v = 0; v < coarse_of.size(); ++v) fine.side[v] = coarse.side[coarse_of[v]];
  return fine;
}

Separator refined(const Graph& graph, const Separator& coarse, const std::vector<int>& coarse_of) {
  Separator separator = project(coarse, coarse_of);
  refine(graph, separator, passes_for(graph));
  return separator;
}

struct Search {
  int n_whole = 0;
  int max_weight = 0;
  std::minstd_rand random;

  Separator run(const Graph& graph, std::span<const Coarsening> coarser) {
    const int n = graph.n_vertices();
    if (n <= kCoarsest) return best_grown(graph, random);
    if (!coarser.empty()) return refined(graph, run(coarser[0].graph, coarser.subspan(1)), coarser[0].coarse_of);
    const Coarsening coarsening = coarsen(graph, max_weight, random);
    const int n_coarse = coarsening.graph.n_vertices();
    if (n_coarse > 0.95 * n) return best_grown(graph, random);
    const int n_repeat = std::max(2 * kCoarsest, n_whole / kRunsShare);
    const int n_runs = n_whole > kLarge && n > n_repeat && n_coarse <= n_repeat ? kRuns : 1;
    Separator best = run(coarsening.graph, {});
    for (int k = 1; k < n_runs; ++k) {
      Separator separator = run(coarsening.graph, {});
      if (separator_cost(separator) < separator_cost(best)) best = std::move(separator);
    }
    return refined(graph, best, coarsening.coarse_of);
  }
};

}  // namespace

Separator find_separator(const Graph& graph, std::span<const Coarsening> coarser) {
  const int max_weight = std::max(1, static_cast<int>(1.5 * graph.total_weight() / kCoarsest));
  return Search{graph.n_vertices(), max_weight, std::minstd_rand()}.run(graph, coarser);
}

}  // namespace arap
