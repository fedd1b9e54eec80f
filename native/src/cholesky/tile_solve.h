// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "base/aligned_buffer.h"
#include "cholesky/linear_solver.h"
#include "cholesky/multifrontal.h"
#include "cholesky/tile_plan.h"
#include "kernels/kernels.h"
#include "parallel/workers.h"

namespace arap {

/// A factor as tiles, and its solve: forward elimination up the tree, back substitution down. The digits of the result
/// depend on the plan, not on which threads take part.
class TileFactorization final : public Factorization {
 public:
  /// @param scaling  of the factorized matrix
  TileFactorization(std::shared_ptr<const TilePlan> plan, Workers workers, const TileKernels& kernels,
                    AlignedBuffer<std::byte> tiles, const Scaling& scaling);

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override;
  [[nodiscard]] size_t bytes() const override { return tiles_.size(); }

 private:
  /// Memory of one solve; several may run at the same time.
  struct Workspace {
    explicit Workspace(const TilePlan& plan);

    AlignedBuffer<float> x;       ///< (n_places, 4)
    AlignedBuffer<float> packed;  ///< b1 of a supernode that threads share, then its x1
    std::vector<double> largest;  ///< |b| of each subtree, then of the root part
  };

  void solve_with(const Positions& b, Positions& x, Workspace& work) const;
  /// Elimination below the root part. Returns about the largest |b| times `factor`, not finite if b is not.
  [[nodiscard]] double eliminate_subtrees(const Positions& b, double factor, Workspace& work) const;
  /// Replaces y of the root part by x.
  void solve_root_part(Workspace& work) const;
  void substitute_subtrees(Positions& x, double factor, Workspace& work) const;
  /// Reads the columns of the supernodes [first, last) from b; returns an upper bound of the largest |b|.
  [[nodiscard]] float read_columns(const Positions& b, double factor, int first, int last, float* x) const;
  void write_columns(Positions& result, double factor, int first, int last, const float* x) const;
  void forward_subtree(int index, float* x) const;
  void backward_subtree(int index, float* x) const;
  void collect_root_part(float* x) const;
  /// One supernode by all threads.
  void forward_shared(const TileSupernode& node, Workspace& work) const;
  void backward_shared(const TileSupernode& node, Workspace& work) const;

  std::shared_ptr<const TilePlan> plan_;
  Workers workers_;
  const TileKernels& kernels_;
  AlignedBuffer<std::byte> tiles_;
  std::vector<TileSupernode> supernodes_;
  double scale_;                ///< Scaling::of_all
  std::vector<float> scaling_;  ///< Scaling::of_each, in the factor's ordering
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> idle_;
};

}  // namespace arap
