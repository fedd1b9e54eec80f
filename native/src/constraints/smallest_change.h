// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "constraints/linear_rows.h"
#include "parallel/workers.h"

namespace arap {

/// The smallest change of the unknowns, in the sum of their squares, that closes the gaps of rows. Rows that repeat or
/// contradict each other, or that fixed unknowns leave no way, are met to the least squares. Conjugate gradients on the
/// rows as they are: time and memory grow with their entries.
class SmallestChange {
 public:
  /// None.
  SmallestChange() = default;
  /// @param rows      the weights say what a gap counts
  /// @param is_fixed  (n,) unknowns that stay
  SmallestChange(const LinearRows& rows, const std::vector<char>& is_fixed);

  [[nodiscard]] bool empty() const { return rows_.empty(); }
  /// @param gaps  (n_rows, 3) target minus what x has
  /// @param x     (n, 3)
  void close(const Positions& gaps, Positions& x, const Workers& workers) const;

 private:
  std::vector<int> unknowns_;  ///< that rows have
  Eigen::ArrayXd scales_;      ///< roots of the weights
  RowMatrix rows_;             ///< times these, over unknowns_
};

}  // namespace arap
