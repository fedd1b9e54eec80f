// SPDX-License-Identifier: GPL-3.0-or-later
#include "sparse/sparse.h"

#include <algorithm>
#include <utility>

#include "base/union_find.h"
#include "parallel/parallel.h"

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

SparseMatrix renumbered(const SparseMatrix& A, const std::vector<int>& ordering, const std::vector<int>& new_of_old,
                        int threads) {
  SparseMatrix result(A.rows(), A.cols());
  result.resizeNonZeros(A.nonZeros());
  int* offsets = result.outerIndexPtr();
  offsets[0] = 0;
  for (size_t k = 0; k < ordering.size(); ++k)
    offsets[k + 1] = offsets[k] + A.outerIndexPtr()[ordering[k] + 1] - A.outerIndexPtr()[ordering[k]];
  parallel_for(threads, static_cast<int>(ordering.size()), [&](int begin, int end) {
    std::vector<std::pair<int, double>> column;
    for (int k = begin; k < end; ++k) {
      column.clear();
      for (SparseMatrix::InnerIterator it(A, ordering[k]); it; ++it)
        column.emplace_back(new_of_old[it.row()], it.value());
      std::sort(column.begin(), column.end());
      for (size_t e = 0; e < column.size(); ++e) {
        result.innerIndexPtr()[offsets[k] + static_cast<int>(e)] = column[e].first;
        result.valuePtr()[offsets[k] + static_cast<int>(e)] = column[e].second;
      }
    }
  });
  return result;
}

std::vector<int> connected_components(const SparseMatrix& A) {
  const auto n = static_cast<int>(A.cols());
  UnionFind sets(n);
  for (int column = 0; column < n; ++column)
    for (SparseMatrix::InnerIterator it(A, column); it && it.row() < column; ++it)
      if (it.value() != 0) sets.join(column, static_cast<int>(it.row()));
  std::vector<int> components(n);
  for (int i = 0; i < n; ++i) components[i] = sets.find(i);
  return components;
}

}  // namespace arap
