// SPDX-License-Identifier: GPL-3.0-or-later
#include "ordering/nested_dissection.h"

#include <gtest/gtest.h>

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "arap/error.h"
#include "cholesky/elimination_tree.h"
#include "ordering/minimum_degree.h"
#include "ordering/multilevel_graph.h"
#include "ordering/separator.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Graph;
using arap::Separator;
using arap::SparseMatrix;
using Edges = std::vector<std::array<int, 2>>;

struct NamedGraph {
  std::string name;
  int n;
  Edges edges;
};

std::ostream& operator<<(std::ostream& out, const NamedGraph& graph) { return out << graph.name; }

Edges path(int n) {
  Edges edges;
  for (int i = 0; i + 1 < n; ++i) edges.push_back({i, i + 1});
  return edges;
}

Edges star(int n) {
  Edges edges;
  for (int i = 1; i < n; ++i) edges.push_back({0, i});
  return edges;
}

Edges complete(int n) {
  Edges edges;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) edges.push_back({i, j});
  return edges;
}

/// n x n, neighbours along both axes and one diagonal: as a triangulated sheet.
Edges sheet(int n) {
  Edges edges;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (i + 1 < n) edges.push_back({i * n + j, (i + 1) * n + j});
      if (j + 1 < n) edges.push_back({i * n + j, i * n + j + 1});
      if (i + 1 < n && j + 1 < n) edges.push_back({i * n + j, (i + 1) * n + j + 1});
    }
  }
  return edges;
}

Edges random_edges(int n, int n_edges) {
  Random random(3);
  Edges edges;
  for (int k = 0; k < n_edges; ++k)
    edges.push_back({static_cast<int>(random.uniform(0, n)), static_cast<int>(random.uniform(0, n))});
  return edges;
}

/// The same graph with shuffled vertices.
Edges shuffled(int n, Edges edges) {
  Random random(5);
  std::vector<int> name(n);
  std::iota(name.begin(), name.end(), 0);
  for (int i = n - 1; i > 0; --i) std::swap(name[i], name[static_cast<int>(random.uniform(0, i + 1))]);
  for (auto& edge : edges) edge = {name[edge[0]], name[edge[1]]};
  return edges;
}

/// `copies` of the graph beside each other.
Edges repeated(int n, const Edges& edges, int copies) {
  Edges result;
  for (int k = 0; k < copies; ++k)
    for (const auto& [a, b] : edges) result.push_back({a + k * n, b + k * n});
  return result;
}

Edges with_hub(int n, Edges edges) {
  for (int i = 0; i < n; ++i) edges.push_back({i, n});
  return edges;
}

std::vector<NamedGraph> graphs() {
  return {{"nothing", 0, {}},
          {"one", 1, {}},
          {"without_edges", 500, {}},
          {"path", 1000, path(1000)},
          {"star", 1000, star(1000)},
          {"small_star", 110, star(110)},
          {"complete", 150, complete(150)},
          {"sheet", 60 * 60, sheet(60)},
          {"shuffled_sheet", 60 * 60, shuffled(60 * 60, sheet(60))},
          {"small_sheet", 81, sheet(9)},
          {"many_small_ones", 9 * 400, repeated(9, sheet(3), 400)},
          {"two_sheets", 2 * 900, repeated(900, sheet(30), 2)},
          {"sheet_with_hub", 901, with_hub(900, sheet(30))},
          {"random", 600, random_edges(600, 1500)},
          {"dense_random", 300, random_edges(300, 9000)}};
}

SparseMatrix pattern_of(const NamedGraph& graph) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < graph.n; ++i) entries.emplace_back(i, i, 1);
  for (const auto& [i, j] : graph.edges) {
    if (i == j) continue;
    entries.emplace_back(i, j, 1);
    entries.emplace_back(j, i, 1);
  }
  SparseMatrix pattern(graph.n, graph.n);
  pattern.setFromTriplets(entries.begin(), entries.end());
  return pattern;
}

Graph graph_of(const NamedGraph& named) {
  const SparseMatrix pattern = pattern_of(named);
  Graph graph;
  for (int i = 0; i < named.n; ++i) {
    for (SparseMatrix::InnerIterator it(pattern, i); it; ++it)
      if (it.row() != i) graph.neighbours.push_back(static_cast<int>(it.row()));
    graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
  }
  graph.weigh_alike();
  return graph;
}

double fill(const SparseMatrix& pattern, const std::vector<int>& order) {
  const auto tree = arap::make_elimination_tree(pattern, order);
  return std::accumulate(tree.count.begin(), tree.count.end(), 0.0);
}

std::vector<int> approximate_minimum_degree(const SparseMatrix& pattern) {
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(pattern, permutation);
  return {permutation.indices().begin(), permutation.indices().end()};
}

void expect_separates(const Graph& graph, const Separator& separator) {
  std::array<int, 3> weights{};
  ASSERT_EQ(std::ssize(separator.side), graph.n_vertices());
  for (int v = 0; v < graph.n_vertices(); ++v) {
    weights[separator.side[v]] += graph.weights[v];
    for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e)
      EXPECT_NE(separator.side[v] + separator.side[graph.neighbours[e]], 1) << v << " touches the other side";
  }
  EXPECT_EQ(weights, separator.weights);
}

class NestedDissection : public testing::TestWithParam<NamedGraph> {};

INSTANTIATE_TEST_SUITE_P(Graphs, NestedDissection, testing::ValuesIn(graphs()),
                         [](const auto& graph) { return graph.param.name; });

TEST_P(NestedDissection, IsAPermutationOfAllUnknowns) {
  std::vector<int> order = arap::nested_dissection(pattern_of(GetParam()), 2);
  std::sort(order.begin(), order.end());
  std::vector<int> all(GetParam().n);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(order, all);
}

TEST_P(NestedDissection, DoesNotDependOnTheThreads) {
  const SparseMatrix pattern = pattern_of(GetParam());
  const std::vector<int> order = arap::nested_dissection(pattern, 1);
  for (const int threads : {1, 2, 3, 8}) EXPECT_EQ(arap::nested_dissection(pattern, threads), order) << threads;
}

/// AMD is as good on meshes, and better on paths and graphs without small separators.
TEST_P(NestedDissection, FillsAboutAsMuchAsApproximateMinimumDegree) {
  const SparseMatrix pattern = pattern_of(GetParam());
  const bool is_mesh = GetParam().name.find("sheet") != std::string::npos;
  EXPECT_LE(fill(pattern, arap::nested_dissection(pattern, 1)),
            (is_mesh ? 1.1 : 1.5) * fill(pattern, approximate_minimum_degree(pattern)));
}

TEST_P(NestedDissection, SeparatorsSeparate) {
  const Graph graph = graph_of(GetParam());
  if (graph.n_vertices() == 0) return;
  expect_separates(graph, arap::find_separator(graph));
}

TEST_P(NestedDissection, RefiningNeverCosts) {
  const Graph graph = graph_of(GetParam());
  Random random(7);
  // Any sides, with everything between that touches both.
  Separator separator{std::vector<Separator::Side>(graph.n_vertices()), {}};
  for (Separator::Side& side : separator.side) side = random.uniform(0, 1) < 0.5 ? 0 : 1;
  for (int v = 0; v < graph.n_vertices(); ++v)
    for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e)
      if (separator.side[v] + separator.side[graph.neighbours[e]] == 1) separator.side[v] = Separator::kBetween;
  for (int v = 0; v < graph.n_vertices(); ++v) separator.weights[separator.side[v]] += graph.weights[v];
  const arap::SeparatorCost before = arap::separator_cost(separator);
  arap::refine(graph, separator, 4);
  expect_separates(graph, separator);
  EXPECT_LE(arap::separator_cost(separator), before);
}

TEST_P(NestedDissection, CoarseGraphsHaveTheSameWeightAndAboutHalfTheVertices) {
  const Graph graph = graph_of(GetParam());
  constexpr int kMaxWeight = 10;
  std::minstd_rand random;
  const arap::Coarsening coarsening = arap::coarsen(graph, kMaxWeight, random);
  const Graph& coarse = coarsening.graph;
  const auto sum = [](const std::vector<int>& values) { return std::accumulate(values.begin(), values.end(), 0L); };
  EXPECT_EQ(sum(coarse.weights), sum(graph.weights));
  EXPECT_LE(coarse.n_vertices(), 0.75 * graph.n_vertices() + 1);
  for (const int weight : coarse.weights) EXPECT_LE(weight, kMaxWeight);
  std::vector<std::vector<int>> expected(coarse.n_vertices(), std::vector<int>(coarse.n_vertices(), 0));
  for (int v = 0; v < graph.n_vertices(); ++v)
    for (int e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e)
      expected[coarsening.coarse_of[v]][coarsening.coarse_of[graph.neighbours[e]]] += graph.edge_weights[e];
  for (int c = 0; c < coarse.n_vertices(); ++c) {
    expected[c][c] = 0;
    for (int e = coarse.offsets[c]; e < coarse.offsets[c + 1]; ++e) {
      EXPECT_GT(coarse.edge_weights[e], 0);
      expected[c][coarse.neighbours[e]] -= coarse.edge_weights[e];
    }
    EXPECT_TRUE(std::all_of(expected[c].begin(), expected[c].end(), [](int left) { return left == 0; })) << c;
  }
}

/// The neighbours of each vertex.
std::vector<std::set<int>> neighbours_of(const Graph& graph) {
  std::vector<std::set<int>> neighbours(graph.n_vertices());
  for (int v = 0; v < graph.n_vertices(); ++v)
    neighbours[v].insert(graph.neighbours.begin() + graph.offsets[v], graph.neighbours.begin() + graph.offsets[v + 1]);
  return neighbours;
}

/// Expects that a coarse vertex weighs as much as its fine vertices, and that every fine edge has a coarse edge.
void expect_stands_for(const arap::Coarsening& coarsening, const Graph& fine) {
  std::vector<int> weights(coarsening.graph.n_vertices(), 0);
  const std::vector<std::set<int>> neighbours = neighbours_of(coarsening.graph);
  ASSERT_EQ(std::ssize(coarsening.coarse_of), fine.n_vertices());
  for (int v = 0; v < fine.n_vertices(); ++v) {
    const int c = coarsening.coarse_of[v];
    weights[c] += fine.weights[v];
    for (int e = fine.offsets[v]; e < fine.offsets[v + 1]; ++e) {
      const int other = coarsening.coarse_of[fine.neighbours[e]];
      EXPECT_TRUE(other == c || neighbours[c].count(other) == 1) << v;
    }
  }
  EXPECT_EQ(weights, coarsening.graph.weights);
}

TEST_P(NestedDissection, SeparatorsHaveTheEntriesThatTheyForetell) {
  const Graph graph = graph_of(GetParam());
  if (graph.n_vertices() == 0) return;
  const Separator separator = arap::find_separator(graph);
  std::vector<int> order(graph.n_vertices());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return separator.side[a] < separator.side[b]; });
  const int n_before = separator.weights[0] + separator.weights[1];
  EXPECT_LE(n_before + static_cast<double>(arap::least_entries(graph, separator)), fill(pattern_of(GetParam()), order));
}

TEST_P(NestedDissection, SidesAreWhatIsLeftOfTheGraphAndOfItsCoarserOnes) {
  const Graph graph = graph_of(GetParam());
  if (graph.n_vertices() == 0) return;
  const arap::GraphHierarchy whole = arap::make_hierarchy(graph);
  const Separator separator = arap::find_separator(whole.graph, whole.coarser);
  expect_separates(graph, separator);
  const std::vector<std::set<int>> neighbours = neighbours_of(graph);
  const auto sides = arap::divide(whole, separator, 0);
  for (int side = 0; side < 2; ++side) {
    const std::vector<int>& vertices = sides[side].vertices;
    EXPECT_EQ(std::ssize(vertices), std::count(separator.side.begin(), separator.side.end(), side));
    const Graph* finest = &sides[side].hierarchy.graph;
    const std::vector<std::set<int>> left = neighbours_of(*finest);
    for (int k = 0; k < std::ssize(vertices); ++k) {
      EXPECT_EQ(separator.side[vertices[k]], side);
      std::set<int> expected;
      for (int other = 0; other < std::ssize(vertices); ++other)
        if (neighbours[vertices[k]].count(vertices[other]) == 1) expected.insert(other);
      EXPECT_EQ(left[k], expected);
    }
    EXPECT_EQ(sides[side].hierarchy.coarser.size(), vertices.empty() ? 0U : whole.coarser.size());
    for (const arap::Coarsening& coarsening : sides[side].hierarchy.coarser) {
      expect_stands_for(coarsening, *finest);
      finest = &coarsening.graph;
    }
  }
}

TEST(Separators, CutASheetInTheMiddle) {
  constexpr int kSize = 60;
  const Separator separator = arap::find_separator(graph_of({"sheet", kSize * kSize, sheet(kSize)}));
  // A line across it is the least there is.
  EXPECT_LE(separator.weights[2], 1.1 * kSize);
  EXPECT_LE(std::max(separator.weights[0], separator.weights[1]), 0.6 * kSize * kSize);
}

TEST(Separators, OfASheetAreCoupledWholly) {
  const Graph graph = graph_of({"sheet", 3600, sheet(60)});
  const Separator separator = arap::find_separator(graph);
  EXPECT_EQ(arap::least_entries(graph, separator), separator.weights[2] * (separator.weights[2] + 1) / 2);
}

TEST(NestedDissectionFill, IsRefusedIfItsSeparatorsDoNotFit) {
  constexpr int kVertices = 30000;
  const SparseMatrix pattern = pattern_of({"random", kVertices, random_edges(kVertices, 6 * kVertices)});
  constexpr size_t kEntryBytes = size_t{1} << 40U;
  for (const int threads : {1, 2})
    EXPECT_THROW(static_cast<void>(arap::nested_dissection(pattern, threads, {}, kEntryBytes)), arap::NotEnoughMemory);
}

TEST(Separators, OfAPathAreOneVertex) {
  const Separator separator = arap::find_separator(graph_of({"path", 1000, path(1000)}));
  EXPECT_EQ(separator.weights[2], 1);
}

TEST(Separators, OfWhatIsNotConnectedAreEmpty) {
  const Separator separator = arap::find_separator(graph_of({"two_sheets", 1800, repeated(900, sheet(30), 2)}));
  EXPECT_EQ(separator.weights[2], 0);
  EXPECT_EQ(separator.weights[0], 900);
}

/// George 1973: a factor of O(n log n) entries, 31/4 n log2 n on a sheet by cutting in the middle.
TEST(NestedDissectionFill, GrowsAsTheTheoryHasIt) {
  for (const int size : {20, 40, 80, 160}) {
    const double n = size * size;
    const SparseMatrix pattern = pattern_of({"sheet", size * size, sheet(size)});
    EXPECT_LE(fill(pattern, arap::nested_dissection(pattern, 1)), 31.0 / 4 * n * std::log2(n) / 2) << size;
  }
}

TEST(MinimumDegree, LeavesATreeWithoutFill) {
  const NamedGraph tree{"path", 100, shuffled(100, path(100))};
  const SparseMatrix pattern = pattern_of(tree);
  EXPECT_EQ(fill(pattern, arap::nested_dissection(pattern, 1)), 199);
}

TEST(MinimumDegree, CountsNeighboursThatStay) {
  // 0 - 1 - 2, and two vertices that stay beside 0: the other end goes first, though both ends have one neighbour here.
  std::vector<arap::SmallRow> rows(3);
  for (const int neighbour : {1, 3, 4}) rows[0].set(neighbour);
  for (const int neighbour : {0, 2}) rows[1].set(neighbour);
  rows[2].set(1);
  EXPECT_EQ(arap::minimum_degree(rows, 3), (std::vector<int>{2, 1, 0}));
}

}  // namespace
}  // namespace arap_test
