// SPDX-License-Identifier: GPL-3.0-or-later
#include "cell_energy.h"

#include <algorithm>
#include <span>
#include <utility>

#include "parallel.h"
#include "permutation.h"
#include "sparse_rows.h"

namespace arap {

void multiply(const SparseMatrix& A, const Positions& x, Positions& result, const Workers& workers) {
  result.resize(A.rows(), 3);
  parallel_for(workers, static_cast<int>(A.cols()), [&](int begin, int end) {
    for (int column = begin; column < end; ++column) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (SparseMatrix::InnerIterator it(A, column); it; ++it) sum += it.value() * x.row(it.row());
      result.row(column) = sum;
    }
  });
}

namespace {

using Rows = SparseRows<Vector3>;

/// Where the next entry of each cell goes, share by share: the home is the first of a cell, then come the shares in
/// order.
std::vector<std::vector<int>> place_shares(const Rows& rows, const std::vector<int>& homes,
                                           std::vector<int>& cell_offsets) {
  std::vector<std::vector<int>> next(rows.n_shares(), std::vector<int>(homes.size(), 0));
  std::vector<char> has_home(homes.size(), 0);
  rows.for_each([&](int share, int vertex, std::span<const Rows::Entry> entries) {
    for (const auto& [cell, q] : entries)
      if (homes[cell] == vertex)
        has_home[cell] = 1;
      else
        ++next[share][cell];
  });
  cell_offsets.assign(1, 0);
  cell_offsets.reserve(homes.size() + 1);
  for (size_t c = 0; c < homes.size(); ++c) {
    int place = cell_offsets.back() + has_home[c];
    for (std::vector<int>& next_of_share : next) place += std::exchange(next_of_share[c], place);
    cell_offsets.push_back(place);
  }
  return next;
}

}  // namespace

void CellEnergy::set_cells(const SparseRows<Vector3>& rows, const std::vector<int>& homes) {
  std::vector<std::vector<int>> next = place_shares(rows, homes, cell_offsets);
  cell_vertices.resize(cell_offsets.back());
  q.resize(cell_offsets.back(), 3);
  vertex_offsets = rows.offsets();
  vertex_incidences.resize(cell_vertices.size());
  vertex_cells.resize(cell_vertices.size());
  rows.for_each([&](int share, int vertex, std::span<const Rows::Entry> entries) {
    int k = vertex_offsets[vertex];
    for (const auto& [cell, value] : entries) {
      const int slot = homes[cell] == vertex ? cell_offsets[cell] : next[share][cell]++;
      cell_vertices[slot] = vertex;
      q.row(slot) = value.transpose();
      vertex_incidences[k] = slot;
      vertex_cells[k++] = cell;
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

namespace {

/// P K P^T, columns with their rows in order.
SparseMatrix renumbered(const SparseMatrix& K, const std::vector<int>& order, const std::vector<int>& new_of_old,
                        int threads) {
  SparseMatrix result(K.rows(), K.cols());
  result.resizeNonZeros(K.nonZeros());
  int* offsets = result.outerIndexPtr();
  offsets[0] = 0;
  for (size_t k = 0; k < order.size(); ++k)
    offsets[k + 1] = offsets[k] + K.outerIndexPtr()[order[k] + 1] - K.outerIndexPtr()[order[k]];
  parallel_for(threads, static_cast<int>(order.size()), [&](int begin, int end) {
    std::vector<std::pair<int, double>> column;
    for (int k = begin; k < end; ++k) {
      column.clear();
      for (SparseMatrix::InnerIterator it(K, order[k]); it; ++it) column.emplace_back(new_of_old[it.row()], it.value());
      std::sort(column.begin(), column.end());
      for (size_t e = 0; e < column.size(); ++e) {
        result.innerIndexPtr()[offsets[k] + static_cast<int>(e)] = column[e].first;
        result.valuePtr()[offsets[k] + static_cast<int>(e)] = column[e].second;
      }
    }
  });
  return result;
}

}  // namespace

CellEnergy renumbered(const CellEnergy& energy, const std::vector<int>& order, const std::vector<int>& cell_order,
                      int threads) {
  const std::vector<int> new_of_old = inverse_permutation(order);
  CellEnergy result;
  result.K = renumbered(energy.K, order, new_of_old, threads);
  result.rest_energy = energy.rest_energy;
  result.cell_offsets.assign(1, 0);
  result.cell_offsets.reserve(energy.cell_offsets.size());
  for (const int c : cell_order)
    result.cell_offsets.push_back(result.cell_offsets.back() + energy.cell_offsets[c + 1] - energy.cell_offsets[c]);
  result.cell_vertices.resize(energy.cell_vertices.size());
  result.q.resize(energy.q.rows(), 3);
  parallel_for(threads, energy.n_cells(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      int to = result.cell_offsets[c];
      for (int k = energy.cell_offsets[cell_order[c]]; k < energy.cell_offsets[cell_order[c] + 1]; ++k, ++to) {
        result.cell_vertices[to] = new_of_old[energy.cell_vertices[k]];
        result.q.row(to) = energy.q.row(k);
      }
    }
  });
  result.index_by_vertex();
  return result;
}

}  // namespace arap
