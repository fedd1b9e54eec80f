// SPDX-License-Identifier: GPL-3.0-or-later
#include "ordering/nested_dissection.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>

#include "base/available_memory.h"
#include "ordering/graph.h"
#include "ordering/minimum_degree.h"
#include "ordering/multilevel_graph.h"
#include "ordering/separator.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Pieces of at most this many vertices are ordered by minimum degree.
constexpr int kLeafSize = 160;
static_assert(kLeafSize <= kMinimumDegreeSize);
constexpr std::ptrdiff_t kPiecesPerThread = 8;
/// What smaller separators need decides nothing.
constexpr int kLargeSeparator = 5000;

int degree(const SparseMatrix& pattern, int i) {
  return pattern.outerIndexPtr()[i + 1] - pattern.outerIndexPtr()[i] - 1;
}

/// A subgraph, and where in the ordering its vertices begin.
struct Piece {
  std::vector<int> vertices;  ///< of the whole graph, ascending
  GraphHierarchy hierarchy;
  int begin = 0;
};

/// The graph of some unknowns. Sorts them breadth first, so that neighbours are close in memory, also within pieces.
Graph make_graph(const SparseMatrix& pattern, std::vector<int>& unknowns) {
  constexpr int kElsewhere = -2;
  constexpr int kNotReached = -1;
  std::vector<int> index(pattern.rows(), kElsewhere);
  for (const int i : unknowns) index[i] = kNotReached;
  std::vector<int> reached;
  reached.reserve(unknowns.size());
  const auto reach = [&](int i) {
    if (index[i] != kNotReached) return;
    index[i] = static_cast<int>(reached.size());
    reached.push_back(i);
  };
  Graph graph;
  graph.offsets.reserve(unknowns.size() + 1);
  graph.neighbours.reserve(pattern.nonZeros());
  size_t k = 0;
  for (const int seed : unknowns) {
    reach(seed);
    for (; k < reached.size(); ++k) {
      for (SparseMatrix::InnerIterator it(pattern, reached[k]); it; ++it) {
        const auto neighbour = static_cast<int>(it.row());
        if (neighbour == reached[k] || index[neighbour] == kElsewhere) continue;
        reach(neighbour);
        graph.neighbours.push_back(index[neighbour]);
      }
      graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
    }
  }
  graph.weigh_alike();
  unknowns = std::move(reached);
  return graph;
}

class Dissection {
 public:
  Dissection(const Graph& graph, const MeterPart& meter, size_t entry_bytes)
      : graph_(graph),
        entry_bytes_(static_cast<double>(entry_bytes)),
        // A cut takes as long as all of its halves' together.
        meter_(meter.part(1 / (1 + std::log2(1 + static_cast<double>(graph.n_vertices()) / kLeafSize)))),
        ordering_(graph.n_vertices()) {}

  /// Returns ordering[new] = vertex.
  std::vector<int> run(int threads) {
    std::vector<Piece> pieces;
    pieces.push_back({std::vector<int>(ordering_.size()), make_hierarchy(graph_), 0});
    std::iota(pieces[0].vertices.begin(), pieces[0].vertices.end(), 0);
    while (threads > 1 && std::ssize(pieces) < kPiecesPerThread * threads) {
      std::vector<std::array<Piece, 2>> halves(pieces.size());
      for_each(threads, pieces, [&](int k) { halves[k] = cut(std::move(pieces[k])); });
      pieces.clear();
      for (auto& both : halves)
        for (Piece& half : both) pieces.push_back(std::move(half));
    }
    for_each(threads, pieces, [&](int k) { dissect(std::move(pieces[k])); });
    return std::move(ordering_);
  }

 private:
  /// Calls body(k) for each piece, the largest first; threads take them one by one.
  template <class Body>
  static void for_each(int threads, const std::vector<Piece>& pieces, const Body& body) {
    std::vector<int> queue(pieces.size());
    std::iota(queue.begin(), queue.end(), 0);
    std::stable_sort(queue.begin(), queue.end(),
                     [&](int a, int b) { return pieces[a].vertices.size() > pieces[b].vertices.size(); });
    std::atomic<int> next = 0;
    for_each_piece(threads, threads, [&](int /*thread*/) {
      for (int k = next++; k < std::ssize(queue); k = next++) body(queue[k]);
    });
  }

  /// Cuts a piece into halves and places its separator behind them. A small piece is ordered whole and has no halves.
  std::array<Piece, 2> cut(Piece piece) {
    if (piece.vertices.size() <= kLeafSize) {
      finish(piece);
      report(piece);
      return {};
    }
    const Separator separator = find_separator(piece.hierarchy.graph, piece.hierarchy.coarser);
    if (separator.weights[Separator::kBetween] > kLargeSeparator) require_room(piece.hierarchy.graph, separator);
    std::array<Piece, 2> halves;
    int place = piece.begin;
    std::array<GraphSide, 2> sides = divide(piece.hierarchy, separator, kLeafSize);
    for (size_t k = 0; k < 2; ++k) {
      for (int& v : sides[k].vertices) v = piece.vertices[v];
      halves[k] = {std::move(sides[k].vertices), std::move(sides[k].hierarchy), place};
      place += static_cast<int>(halves[k].vertices.size());
    }
    for (size_t v = 0; v < piece.vertices.size(); ++v)
      if (separator.side[v] == Separator::kBetween) ordering_[place++] = piece.vertices[v];
    report(piece);
    return halves;
  }

  /// Separators do not share columns, so what they need adds up.
  void require_room(const Graph& graph, const Separator& separator) {
    require_memory(entry_bytes_ * static_cast<double>(least_entries_ += least_entries(graph, separator)),
                   "the factor of this mesh");
  }

  void dissect(Piece piece) {
    std::array<Piece, 2> halves = cut(std::move(piece));
    for (Piece& half : halves)
      if (!half.vertices.empty()) dissect(std::move(half));
  }

  void finish(const Piece& piece) {
    const auto n = static_cast<int>(piece.vertices.size());
    const Graph& graph = piece.hierarchy.graph;
    std::vector<SmallRow> rows(n);
    std::vector<std::pair<int, int>> outside;  // neighbour in the whole graph, vertex
    for (int v = 0; v < n; ++v) {
      for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e) rows[v].set(graph.neighbours[e]);
      const int whole = piece.vertices[v];
      if (graph.degree(v) == graph_.degree(whole)) continue;
      for (int e = graph_.offsets[whole]; e < graph_.offsets[whole + 1]; ++e) {
        const int u = graph_.neighbours[e];
        if (!std::binary_search(piece.vertices.begin(), piece.vertices.end(), u)) outside.emplace_back(u, v);
      }
    }
    std::sort(outside.begin(), outside.end());
    int column = n - 1;
    int former = -1;
    for (const auto& [neighbour, v] : outside) {
      if (neighbour != former) ++column;
      former = neighbour;
      if (column >= kMinimumDegreeSize) break;
      rows[v].set(column);
    }
    int place = piece.begin;
    for (const int v : minimum_degree(std::move(rows), n)) ordering_[place++] = piece.vertices[v];
  }

  void report(const Piece& piece) const {
    meter_.add(static_cast<double>(piece.vertices.size()) / graph_.n_vertices());
  }

  const Graph& graph_;
  double entry_bytes_;
  std::atomic<std::int64_t> least_entries_ = 0;
  MeterPart meter_;  ///< for each level of cuts
  std::vector<int> ordering_;
};

}  // namespace

std::vector<int> nested_dissection(const SparseMatrix& pattern, int threads, const MeterPart& meter,
                                   size_t entry_bytes) {
  const auto n = static_cast<int>(pattern.rows());
  // Isolated unknowns come first. Unknowns with very many neighbours come last: they would be in every separator and
  // hide the shape of the rest.
  const double dense = 16 + 10 * std::sqrt(static_cast<double>(n));
  std::vector<int> ordering;
  std::vector<int> inner;
  std::vector<int> last;
  ordering.reserve(n);
  for (int i = 0; i < n; ++i) {
    const int d = degree(pattern, i);
    (d <= 0 ? ordering : d > dense ? last : inner).push_back(i);
  }
  const Graph graph = make_graph(pattern, inner);
  for (const int v : Dissection(graph, meter, entry_bytes).run(threads)) ordering.push_back(inner[v]);
  ordering.insert(ordering.end(), last.begin(), last.end());
  return ordering;
}

}  // namespace arap
