// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
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
  void solve(const Positions& b, Positions& x) const override { solve(b, {}, x); }
  [[nodiscard]] std::unique_ptr<Border> border(const SparseMatrix& columns, const MeterPart& meter) const override;
  [[nodiscard]] size_t bytes() const override { return tiles_.size(); }

  /// Changes y = L^-1 b, in places of 4, which holds `factor` times the true one, 0 if all of it is 0. Returns the
  /// factor of what it leaves there.
  using Change = std::function<double(float* y, double factor)>;
  /// @param change  between elimination and back substitution; may be empty
  void solve(const Positions& b, const Change& change, Positions& x) const;

  /// The elimination of a b that is 0 but in the columns of `path`: of supernodes with all that are above them,
  /// ascending. It leaves every place 0 but these columns.
  /// @param x  (n_places, 4), 0 where b is
  void eliminate_along(std::span<const int> path, float* x) const;
  /// What b is multiplied with in column `c` of the factor, before the elimination.
  [[nodiscard]] double scale(int c) const { return scale_ * static_cast<double>(scaling_[c]); }
  [[nodiscard]] const TilePlan& plan() const { return *plan_; }
  [[nodiscard]] const Workers& workers() const { return workers_; }

 private:
  /// Memory of one solve; several may run at the same time.
  struct Workspace {
    explicit Workspace(const TilePlan& plan);

    AlignedBuffer<float> x;       ///< (n_places, 4)
    AlignedBuffer<float> packed;  ///< b1 of a supernode that threads share, then its x1
    std::vector<double> largest;  ///< |b| of each subtree, then of the root part
  };

  void solve_with(const Positions& b, const Change& change, Positions& x, Workspace& work) const;
  /// Elimination below the root part. Returns about the largest |b| times `factor`, not finite if b is not.
  [[nodiscard]] double eliminate_subtrees(const Positions& b, double factor, Workspace& work) const;
  void eliminate_root_part(Workspace& work) const;
  void substitute_root_part(Workspace& work) const;
  void substitute_subtrees(Positions& x, double factor, Workspace& work) const;
  /// Reads the columns of the supernodes [first, last) from b; returns an upper bound of the largest |b|.
  [[nodiscard]] float read_columns(const Positions& b, double factor, int first, int last, float* x) const;
  void write_columns(Positions& result, double factor, int first, int last, const float* x) const;
  void forward_subtree(int index, float* x) const;
  void backward_subtree(int index, float* x) const;
  /// Adds its copies to the columns of the root part.
  static void collect(const TilePlan::Copies& copies, float* x);
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
