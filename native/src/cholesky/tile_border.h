// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "base/aligned_buffer.h"
#include "cholesky/linear_solver.h"

namespace arap {

class TileFactorization;

/// The columns B = L^-1 C beside a factor of tiles, M = L L^T. So C^T M^-1 C = B^T B, and a solve takes B y out between
/// its elimination and its back substitution: it needs no other solve.
///
/// A column of C with few entries fills B only along their paths to the root of the elimination tree: O(sqrt(n)) of a
/// surface's n rows. Only these are eliminated and stored. The kernels take three columns at a time: columns that are
/// near each other in the tree, whose paths are nearly one.
class TileBorder final : public Border {
 public:
  /// @param factor  outlives the border
  TileBorder(const TileFactorization& factor, const SparseMatrix& columns, const MeterPart& meter);

  [[nodiscard]] Eigen::MatrixXd products() const override;
  void solve(const Choose& choose, Positions& x) const override;

 private:
  /// Three columns.
  struct Triple {
    std::vector<int> path;   ///< supernodes, ascending
    std::vector<int> place;  ///< of the triple among those of each of them
  };
  /// Rows of B: of some neighbouring columns of the factor in one supernode.
  struct Block {
    int supernode;
    int first;      ///< column of the factor
    int n_rows;     ///< of B
    size_t values;  ///< they begin here: row by row, three for each of the supernode's triples
  };

  void sort_columns(const SparseMatrix& columns, const std::vector<int>& new_index);
  void find_paths(const SparseMatrix& columns, const std::vector<int>& new_index);
  void make_blocks();
  /// Returns the largest value.
  float eliminate(int triple, const SparseMatrix& columns, const std::vector<int>& new_index, float* x);
  [[nodiscard]] const int* triples_of(int s) const { return triples_.data() + triple_offsets_[s]; }
  [[nodiscard]] int triple_count(int s) const { return triple_offsets_[s + 1] - triple_offsets_[s]; }
  /// (3 triple_count, n_rows)
  [[nodiscard]] Eigen::Map<const Eigen::MatrixXf> values_of(const Block& block) const {
    return {values_.data() + block.values, Eigen::Index{3} * triple_count(block.supernode), block.n_rows};
  }
  void add_products(int first_triple, int last_triple, Eigen::MatrixXd& sorted) const;
  /// B^T y / factor, sorted and scaled as B is.
  [[nodiscard]] Eigen::MatrixX3d products_with(const float* y, double factor) const;
  /// y = to_factor (y / factor - B by)
  void take_out(const Eigen::MatrixX3d& by, double factor, double to_factor, float* y) const;

  const TileFactorization& factor_;
  std::vector<int> sorted_;          ///< columns of C in the order of B's
  Eigen::VectorXd scales_;           ///< of B's columns, powers of two: their numbers are floats
  std::vector<Triple> of_triple_;    ///< empty after construction
  std::vector<int> triple_offsets_;  ///< of each supernode, and the end
  std::vector<int> triples_;         ///< of supernode after supernode, ascending
  std::vector<Block> blocks_;
  std::vector<int> pieces_;  ///< of blocks, for threads: they begin here, and the end
  AlignedBuffer<float> values_;
  float largest_ = 0;  ///< of the values
};

}  // namespace arap
