// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface_distance.h"

#include "parallel.h"

namespace arap {

SurfaceGraph::SurfaceGraph(const SparseMatrix& K, const Positions& rest, int threads) : offsets_(K.cols() + 1, 0) {
  const auto n = static_cast<int>(K.cols());
  for (int v = 0; v < n; ++v) {
    int count = 0;
    for (SparseMatrix::InnerIterator it(K, v); it; ++it) count += it.row() != v ? 1 : 0;
    offsets_[v + 1] = offsets_[v] + count;
  }
  arcs_.resize(offsets_.back());
  parallel_for(threads, n, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      int slot = offsets_[v];
      for (SparseMatrix::InnerIterator it(K, v); it; ++it)
        if (it.row() != v)
          arcs_[slot++] = {static_cast<int>(it.row()), static_cast<float>((rest.row(it.row()) - rest.row(v)).norm())};
    }
  });
}

}  // namespace arap
