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

/// A factor as tiles, and the solve: elimination up the tree, back substitution down. The digits of a result depend on
/// the plan, not on how many threads there are.
class TileFactorization final : public Factorization {
 public:
  /// @param scaling  of the matrix that the tiles are of
  TileFactorization(std::shared_ptr<const TilePlan> plan, Workers workers, const TileKernels& kernels,
                    AlignedBuffer<std::byte> tiles, const Scaling& scaling);

  using Factorization::solve;
  void solve(const Positions& b, Positions& x) const override;
  [[nodiscard]] size_t bytes() const override { return tiles_.size(); }

 private:
  /// What one solve writes to; solves may run at the same time.
  struct Workspace {
    explicit Workspace(const TilePlan& plan);

    AlignedBuffer<float> x;       ///< (n_places, 4)
    AlignedBuffer<float> packed;  ///< b1 of a shared supernode, then x1
    std::vector<double> largest;  ///< |b| of each branch, then of the top
  };

  void solve_with(const Positions& b, Positions& x, Workspace& work) const;
  /// Up to the top. Returns about the largest |b| times `factor`, not finite if b is not.
  [[nodiscard]] double eliminate_branches(const Positions& b, double factor, Workspace& work) const;
  /// Replaces y of the top by its x.
  void solve_top(Workspace& work) const;
  void substitute_branches(Positions& x, double factor, Workspace& work) const;
  /// The columns of the supernodes [first, last); returns the largest, or somewhat more.
  [[nodiscard]] float read_columns(const Positions& b, double factor, int first, int last, float* x) const;
  void write_columns(Positions& result, double factor, int first, int last, const float* x) const;
  void forward_branch(int branch, float* x) const;
  void backward_branch(int branch, float* x) const;
  void collect_top(float* x) const;
  /// One supernode, its parts by all threads.
  void forward_shared(const TileSupernode& node, Workspace& work) const;
  void backward_shared(const TileSupernode& node, Workspace& work) const;

  std::shared_ptr<const TilePlan> plan_;
  Workers workers_;
  const TileKernels& kernels_;
  AlignedBuffer<std::byte> tiles_;
  std::vector<TileSupernode> supernodes_;
  double scale_;                ///< Scaling::of_all
  std::vector<float> scaling_;  ///< Scaling::of_each, in the factor's order
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> idle_;
};

}  // namespace arap
