// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "base/aligned_buffer.h"
#include "kernels/cage_kernels.h"

namespace arap {

/// The weights of many points in single precision, block by block: in a block those of row 0 of all its points, then
/// those of row 1, as the kernels want them.
class WeightBlocks {
 public:
  WeightBlocks(int n_points, int n_rows)
      : n_points_(n_points),
        n_rows_(n_rows),
        weights_(static_cast<size_t>(n_blocks()) * static_cast<size_t>(n_rows) * kCageBlock) {}

  [[nodiscard]] static double bytes(double n_points, double n_rows) {
    return sizeof(float) * (n_points + kCageBlock) * n_rows;
  }

  [[nodiscard]] int n_points() const { return n_points_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] int n_blocks() const { return n_points_ / kCageBlock + (n_points_ % kCageBlock != 0 ? 1 : 0); }
  [[nodiscard]] float& at(int point, int row) {
    return block(point / kCageBlock)[static_cast<std::ptrdiff_t>(kCageBlock) * row + point % kCageBlock];
  }
  /// (n_rows,)
  [[nodiscard]] Eigen::VectorXd of_point(int point) const {
    const float* first = block(point / kCageBlock) + point % kCageBlock;
    Eigen::VectorXd values(n_rows_);
    for (int row = 0; row < n_rows_; ++row)
      values[row] = static_cast<double>(first[static_cast<std::ptrdiff_t>(kCageBlock) * row]);
    return values;
  }
  [[nodiscard]] float* block(int b) { return weights_.data() + offset(b); }
  [[nodiscard]] const float* block(int b) const { return weights_.data() + offset(b); }

 private:
  [[nodiscard]] size_t offset(int b) const {
    return static_cast<size_t>(b) * static_cast<size_t>(n_rows_) * kCageBlock;
  }

  int n_points_;
  int n_rows_;
  AlignedBuffer<float> weights_;
};

}  // namespace arap
