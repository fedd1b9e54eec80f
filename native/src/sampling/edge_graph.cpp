// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/edge_graph.h"

#include "base/offsets.h"
#include "parallel/parallel.h"

namespace arap {

EdgeGraph::EdgeGraph(const SparseMatrix& K, const Positions& rest, int threads,
                     const std::vector<std::pair<int, int>>& links)
    : offsets_(K.cols() + 1, 0) {
  const auto n = static_cast<int>(K.cols());
  const auto length = [&](int a, int b) { return static_cast<float>((rest.row(a) - rest.row(b)).norm()); };
  for (int v = 0; v < n; ++v)
    for (SparseMatrix::InnerIterator it(K, v); it; ++it) offsets_[v + 1] += it.row() != v ? 1 : 0;
  for (const auto& [a, b] : links) {
    ++offsets_[a + 1];
    ++offsets_[b + 1];
  }
  make_offsets(offsets_);
  arcs_.resize(offsets_.back());
  std::vector<int> next(n);
  parallel_for(threads, n, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      next[v] = offsets_[v];
      for (SparseMatrix::InnerIterator it(K, v); it; ++it)
        if (it.row() != v) arcs_[next[v]++] = {static_cast<int>(it.row()), length(static_cast<int>(it.row()), v)};
    }
  });
  for (const auto& [a, b] : links) {
    arcs_[next[a]++] = {b, length(a, b)};
    arcs_[next[b]++] = {a, length(a, b)};
  }
}

}  // namespace arap
