// SPDX-License-Identifier: GPL-3.0-or-later
#include "ordering/separator.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <queue>
#include <random>
#include <utility>
#include <vector>

namespace arap {

namespace {

/// Largest weight of a side, as a part of all.
constexpr double kMaxShare = 0.6;
/// A pass ends after this many moves without improvement, or after about as many as the separator has vertices.
constexpr int kMostVain = 300;
using Cost = SeparatorCost;
using Side = Separator::Side;
constexpr Side kBetween = Separator::kBetween;

int max_side_weight(const Separator& separator) {
  const auto& w = separator.weights;
  return static_cast<int>(kMaxShare * (static_cast<double>(w[0]) + w[1] + w[2]));
}

Cost separator_cost(const Separator& separator, int max_weight) {
  const auto& w = separator.weights;
  return {std::max(std::max(w[0], w[1]) - max_weight, 0), w[2], std::abs(w[0] - w[1])};
}

class Refinement {
 public:
  Refinement(const Graph& graph, Separator& separator)
      : graph_(graph),
        separator_(separator),
        max_weight_(max_side_weight(separator)),
        pulled_(graph.n_vertices()),
        is_moved_(graph.n_vertices(), 0) {
    for (int v = 0; v < graph.n_vertices(); ++v)
      if (separator.side[v] == kBetween) between_.push_back(v);
  }

  void run(int max_passes) {
    for (int pass = 0; pass < max_passes && !between_.empty(); ++pass)
      if (!improve()) return;
  }

 private:
  struct Move {
    int gain;
    int time;  // ties: the latest first, next to the vertices that have just moved
    int vertex;
    bool operator<(const Move& other) const { return std::pair(gain, time) < std::pair(other.gain, other.time); }
  };
  using Moves = std::priority_queue<Move>;

  /// Weight that the separator loses if v moves to a side: v leaves it, its neighbours on the other side enter it.
  [[nodiscard]] int gain(int v, int to) const { return graph_.weights[v] - pulled_[v][1 - to]; }

  void offer(int v, int to) { moves_[to].push({gain(v, to), time_++, v}); }

  /// Updates the heap until its first move is possible and has its present gain. Moves whose gain grew were offered
  /// again, so no other move is better.
  void look_at_first(int to) {
    Moves& moves = moves_[to];
    while (!moves.empty()) {
      const Move& first = moves.top();
      const int v = first.vertex;
      const int time = first.time;
      const bool is_possible = separator_.side[v] == kBetween && is_moved_[v] == 0;
      if (is_possible && gain(v, to) == first.gain) return;
      const bool has_fallen = is_possible && gain(v, to) < first.gain;
      moves.pop();
      if (has_fallen) moves.push({gain(v, to), time, v});
    }
  }

  void measure(int v) {
    pulled_[v] = {0, 0};
    for (int e = graph_.offsets[v]; e < graph_.offsets[v + 1]; ++e) {
      const int u = graph_.neighbours[e];
      if (separator_.side[u] != kBetween) pulled_[v][separator_.side[u]] += graph_.weights[u];
    }
  }

  void set_side(int v, Side side) {
    separator_.weights[separator_.side[v]] -= graph_.weights[v];
    separator_.weights[side] += graph_.weights[v];
    separator_.side[v] = side;
  }

  void change_side(int v, Side side) {
    changes_.emplace_back(v, separator_.side[v]);
    set_side(v, side);
  }

  void move(int v, int to) {
    change_side(v, static_cast<Side>(to));
    is_moved_[v] = 1;
    const int other = 1 - to;
    for (int e = graph_.offsets[v]; e < graph_.offsets[v + 1]; ++e) {
      const int u = graph_.neighbours[e];
      if (separator_.side[u] == kBetween) {
        pulled_[u][to] += graph_.weights[v];  // its gain on the other side falls: see look_at_first()
      } else if (separator_.side[u] == other) {
        pull(u, to);
      }
    }
  }

  /// Takes u from the other side into the separator. Offers it to this side only: each vertex moves once in a pass.
  void pull(int u, int to) {
    const int other = 1 - to;
    change_side(u, kBetween);
    measure(u);
    for (int e = graph_.offsets[u]; e < graph_.offsets[u + 1]; ++e) {
      const int w = graph_.neighbours[e];
      if (separator_.side[w] != kBetween) continue;
      pulled_[w][other] -= graph_.weights[u];
      if (is_moved_[w] == 0) offer(w, to);
    }
    if (is_moved_[u] == 0) offer(u, to);
  }

  /// The side to move to next, -1 if no move is left.
  int choose() {
    for (int to = 0; to < 2; ++to) look_at_first(to);
    const auto& weights = separator_.weights;
    const auto fits = [&](int to) {
      return !moves_[to].empty() && weights[to] + graph_.weights[moves_[to].top().vertex] <= max_weight_;
    };
    const bool fits0 = fits(0);
    const bool fits1 = fits(1);
    if (fits0 && fits1) {
      const int gain0 = moves_[0].top().gain;
      const int gain1 = moves_[1].top().gain;
      if (gain0 != gain1) return gain0 > gain1 ? 0 : 1;
      return weights[0] <= weights[1] ? 0 : 1;
    }
    return fits0 ? 0 : fits1 ? 1 : -1;
  }

  bool improve() {
    changes_.clear();
    for (Moves& moves : moves_) moves = {};
    time_ = 0;
    for (const int v : between_) measure(v);
    for (const int v : between_) {
      offer(v, 0);
      offer(v, 1);
    }
    const Cost cost_before = separator_cost(separator_, max_weight_);
    Cost best = cost_before;
    size_t n_best = 0;
    const int patience = std::min(static_cast<int>(between_.size()) + 5, kMostVain);
    for (int n_vain = 0; n_vain < patience; ++n_vain) {
      const int to = choose();
      if (to < 0) break;
      const int v = moves_[to].top().vertex;
      moves_[to].pop();
      move(v, to);
      const Cost cost = separator_cost(separator_, max_weight_);
      if (cost < best) {
        best = cost;
        n_best = changes_.size();
        n_vain = -1;
      }
    }
    for (const auto& [v, side] : changes_) is_moved_[v] = 0;
    collect(n_best);
    return best < cost_before;
  }

  /// Undoes the changes after the best state.
  void collect(size_t n_best) {
    std::vector<int> touched = std::move(between_);
    for (const auto& [v, side] : changes_) touched.push_back(v);
    while (changes_.size() > n_best) {
      const auto [v, side] = changes_.back();
      set_side(v, side);
      changes_.pop_back();
    }
    between_.clear();
    for (const int v : touched)
      if (separator_.side[v] == kBetween && is_moved_[v] == 0) {
        between_.push_back(v);
        is_moved_[v] = 1;
      }
    for (const int v : between_) is_moved_[v] = 0;
  }

  const Graph& graph_;
  Separator& separator_;
  int max_weight_;
  std::vector<std::array<int, 2>> pulled_;  // of vertices between: weight of their neighbours on each side
  std::vector<char> is_moved_;
  std::vector<int> between_;
  std::array<Moves, 2> moves_;
  std::vector<std::pair<int, Side>> changes_;  // vertex, and its side before
  int time_ = 0;
};

/// Graphs of at most this many vertices are not coarsened but cut directly, kTries times.
constexpr int kCoarsest = 100;
constexpr int kTries = 2;

/// For large graphs the search is repeated kRuns times on a coarse graph, where it is cheap: kRunsShare times smaller.
constexpr int kLarge = 5000;
constexpr int kRuns = 6;
constexpr int kRunsShare = 32;

/// Small graphs take most of the time, large ones gain most from refinement.
int passes_for(const Graph& graph) { return graph.n_vertices() > 4000 ? 8 : 2; }

/// Grows side 0 from one vertex until it has half the weight; its neighbours become the separator.
Separator grow(const Graph& graph, int seed) {
  const int n = graph.n_vertices();
  const int total = graph.total_weight();
  Separator separator{std::vector<Separator::Side>(n, 1), {0, total, 0}};
  std::vector<int> queue{seed};
  std::vector<char> is_queued(n, 0);
  is_queued[seed] = 1;
  int next_seed = 0;
  for (size_t k = 0; std::ptrdiff_t{2} * separator.weights[0] < total; ++k) {
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
    // Queued but not taken: a neighbour of side 0, or the seed of a component that was not needed.
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

std::int64_t least_entries(const Graph& graph, const Separator& separator) {
  constexpr int kUnseen = -1;
  std::vector<int> seen_by(graph.n_vertices(), kUnseen);  // the last connected part that reached a vertex
  std::int64_t most_coupled = 0;
  std::vector<int> open;
  for (int seed = 0; seed < graph.n_vertices(); ++seed) {
    if (separator.side[seed] == Separator::kBetween || seen_by[seed] != kUnseen) continue;
    std::int64_t n_coupled = 0;
    seen_by[seed] = seed;
    open.push_back(seed);
    while (!open.empty()) {
      const int v = open.back();
      open.pop_back();
      for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e) {
        const int u = graph.neighbours[e];
        if (seen_by[u] == seed) continue;
        seen_by[u] = seed;
        if (separator.side[u] == Separator::kBetween)
          ++n_coupled;
        else
          open.push_back(u);
      }
    }
    most_coupled = std::max(most_coupled, n_coupled);
  }
  return most_coupled * (most_coupled + 1) / 2;
}

SeparatorCost separator_cost(const Separator& separator) {
  return separator_cost(separator, max_side_weight(separator));
}

void refine(const Graph& graph, Separator& separator, int max_passes) { Refinement(graph, separator).run(max_passes); }

Separator find_separator(const Graph& graph, std::span<const Coarsening> coarser) {
  const int max_weight = std::max(1, static_cast<int>(1.5 * graph.total_weight() / kCoarsest));
  return Search{graph.n_vertices(), max_weight, std::minstd_rand()}.run(graph, coarser);
}

}  // namespace arap
