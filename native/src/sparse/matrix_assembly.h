// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "sparse/sparse.h"
#include "sparse/sparse_rows.h"

namespace arap {

/// A matrix, (n, n), whose columns are computed in parallel.
/// @param fill  fill(column number, RowAccumulator<double>&), the same from every thread
template <class Fill>
[[nodiscard]] SparseMatrix assemble_matrix(int n, int threads, const Fill& fill, const MeterPart& meter) {
  const SparseRows<double> columns(
      n, n, threads,
      [&] {
        return [&](int i, RowAccumulator<double>& column) {
          fill(i, column);
          column.sort();
        };
      },
      meter);
  SparseMatrix matrix(n, n);
  matrix.resizeNonZeros(columns.offsets().back());
  std::copy(columns.offsets().begin(), columns.offsets().end(), matrix.outerIndexPtr());
  columns.for_each([&](int, int i, const auto& entries) {
    int k = matrix.outerIndexPtr()[i];
    for (const auto& [row, value] : entries) {
      matrix.innerIndexPtr()[k] = row;
      matrix.valuePtr()[k++] = value;
    }
  });
  return matrix;
}

}  // namespace arap
