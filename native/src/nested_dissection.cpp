// SPDX-License-Identifier: GPL-3.0-or-later
#include "nested_dissection.h"

#include <metis.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <new>
#include <utility>

#include "arap/error.h"

namespace arap {

namespace {

/// The adjacency that METIS takes.
struct Graph {
  std::vector<idx_t> offsets;
  std::vector<idx_t> neighbours;
};

int degree(const SparseMatrix& pattern, int i) {
  return pattern.outerIndexPtr()[i + 1] - pattern.outerIndexPtr()[i] - 1;
}

/// Neighbours among `vertices`, which ascend, without loops.
Graph subgraph(const SparseMatrix& pattern, const std::vector<int>& vertices) {
  std::vector<idx_t> index(pattern.rows(), -1);
  for (size_t k = 0; k < vertices.size(); ++k) index[vertices[k]] = static_cast<idx_t>(k);
  Graph graph;
  graph.offsets.reserve(vertices.size() + 1);
  graph.neighbours.reserve(pattern.nonZeros());
  graph.offsets.push_back(0);
  for (const int v : vertices) {
    for (SparseMatrix::InnerIterator it(pattern, v); it; ++it)
      if (it.row() != v && index[it.row()] >= 0) graph.neighbours.push_back(index[it.row()]);
    graph.offsets.push_back(static_cast<idx_t>(graph.neighbours.size()));
  }
  return graph;
}

std::vector<idx_t> dissect(Graph graph) {
  auto n = static_cast<idx_t>(graph.offsets.size() - 1);
  std::vector<idx_t> order(n);
  std::vector<idx_t> inverse(n);
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  // METIS draws from the C library's rand(), seeded at each call: two calls at once would get each other's numbers, and
  // orders that no other run has.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const int status = METIS_NodeND(&n, graph.offsets.data(), graph.neighbours.data(), nullptr, options.data(),
                                  order.data(), inverse.data());
  if (status == METIS_ERROR_MEMORY) throw std::bad_alloc();
  if (status != METIS_OK) throw SolverError("METIS could not order the unknowns");
  return order;
}

}  // namespace

std::vector<int> nested_dissection(const SparseMatrix& pattern) {
  const auto n = static_cast<int>(pattern.rows());
  // Unknowns alone need no order; unknowns beside very many others are in every separator, and would hide the shape of
  // the rest.
  const double dense = 16 + 10 * std::sqrt(static_cast<double>(n));
  std::vector<int> order;
  std::vector<int> inner;
  std::vector<int> last;
  order.reserve(n);
  for (int i = 0; i < n; ++i) {
    const int d = degree(pattern, i);
    (d <= 0 ? order : d > dense ? last : inner).push_back(i);
  }
  Graph graph = subgraph(pattern, inner);
  if (graph.neighbours.empty()) {
    order.insert(order.end(), inner.begin(), inner.end());
  } else {
    for (const idx_t k : dissect(std::move(graph))) order.push_back(inner[k]);
  }
  order.insert(order.end(), last.begin(), last.end());
  return order;
}

}  // namespace arap
