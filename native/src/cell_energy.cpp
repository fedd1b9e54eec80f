// SPDX-License-Identifier: GPL-3.0-or-later
#include "cell_energy.h"

#include "parallel.h"

namespace arap {

void multiply(const SparseMatrix& A, const Positions& x, Positions& result, int threads) {
  result.resize(A.rows(), 3);
  parallel_for(threads, static_cast<int>(A.cols()), [&](int begin, int end) {
    for (int column = begin; column < end; ++column) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (SparseMatrix::InnerIterator it(A, column); it; ++it) sum += it.value() * x.row(it.row());
      result.row(column) = sum;
    }
  });
}

void CellEnergy::index_by_vertex() {
  vertex_offsets.assign(n_vertices() + 1, 0);
  for (const int vertex : cell_vertices) ++vertex_offsets[vertex + 1];
  for (size_t v = 1; v < vertex_offsets.size(); ++v) vertex_offsets[v] += vertex_offsets[v - 1];
  vertex_incidences.resize(cell_vertices.size());
  vertex_cells.resize(cell_vertices.size());
  std::vector<int> next(vertex_offsets.begin(), vertex_offsets.end() - 1);
  for (int c = 0; c < n_cells(); ++c)
    for (int k = cell_offsets[c]; k < cell_offsets[c + 1]; ++k) {
      const auto slot = next[cell_vertices[k]]++;
      vertex_incidences[slot] = k;
      vertex_cells[slot] = c;
    }
}

}  // namespace arap
