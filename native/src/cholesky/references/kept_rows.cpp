// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/references/kept_rows.h"

#include <cmath>

#include "arap/error.h"
#include "base/format_message.h"

namespace arap {

KeptRows::KeptRows(const std::vector<char>& is_erased) : new_index_(is_erased.size(), -1) {
  for (size_t i = 0; i < is_erased.size(); ++i) {
    if (is_erased[i] != 0) continue;
    new_index_[i] = static_cast<int>(kept_.size());
    kept_.push_back(static_cast<int>(i));
  }
}

SparseMatrix KeptRows::of(const SparseMatrix& A) const {
  SparseMatrix result(kept_.size(), kept_.size());
  result.reserve(A.nonZeros());
  for (size_t k = 0; k < kept_.size(); ++k) {
    result.startVec(k);
    double diagonal = 0;
    for (SparseMatrix::InnerIterator it(A, kept_[k]); it; ++it) {
      if (new_index_[it.row()] < 0) continue;
      if (!std::isfinite(it.value())) refuse_entry(it.row(), it.col(), it.value());
      if (it.row() == kept_[k]) diagonal = it.value();
      result.insertBack(new_index_[it.row()], k) = it.value();
    }
    if (!(diagonal > 0)) refuse_indefinite();
  }
  result.finalize();
  return result;
}

void refuse_entry(Eigen::Index row, Eigen::Index column, double value) {
  throw SolverError(text("entry (", row, ", ", column, ") of the system is ", value,
                         "; look for positions, weights and stiffnesses that are not finite"));
}

void refuse_indefinite() {
  throw SolverError("the system is not positive definite; look for parts of the mesh without stiffness");
}

}  // namespace arap
