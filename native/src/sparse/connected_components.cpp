// SPDX-License-Identifier: GPL-3.0-or-later
#include "sparse/connected_components.h"

#include "base/union_find.h"

namespace arap {

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
