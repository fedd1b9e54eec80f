// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "aligned_buffer.h"
#include "kernels.h"
#include "linear_solver.h"
#include "multifrontal.h"
#include "team.h"
#include "team_pace.h"
#include "tile_plan.h"

namespace arap {

/// A factor as tiles, and the solve: elimination up the tree, back substitution down. The digits of a result depend on
/// the plan, not on how many threads there are.
class TileFactorization final : public Factorization {
 public:
  /// @param scaling  of the matrix that the tiles are of
  TileFactorization(std::shared_ptr<const TilePlan> plan, const TileKernels& kernels, AlignedBuffer<std::byte> tiles,
                    const Scaling& scaling);

  void solve(Positions& b) const override;
  [[nodiscard]] size_t bytes() const override { return tiles_.size(); }

 private:
  /// What one solve writes to; solves may run at the same time.
  struct Workspace {
    explicit Workspace(const TilePlan& plan);

    AlignedBuffer<float> x;                       ///< (n_places, 4)
    std::vector<AlignedBuffer<float>> of_thread;  ///< b1 of a shared supernode, then x1
    std::vector<double> largest;                  ///< |b| of what each thread has read
    std::atomic<int> next_forward = 0;
    std::atomic<int> next_backward = 0;
  };

  void solve_in_team(const Team& team, Positions& b, Workspace& work) const;
  /// Up to the top. Returns about the largest |b| times `factor`, NaN if b is not finite; the same to all threads.
  double eliminate_branches(const Team& team, const Positions& b, double factor, Workspace& work) const;
  /// Makes ready for another elimination. Returns the largest |b|, up to a factor of 2 for each thread; NaN as above.
  [[nodiscard]] double start_again(const Team& team, const Positions& b, Workspace& work) const;
  void solve_top(const Team& team, Positions& b, double factor, Workspace& work) const;
  /// The columns of the supernodes [first, last); returns the largest, or somewhat more.
  [[nodiscard]] float read_columns(const Positions& b, double factor, int first, int last, float* x) const;
  void write_columns(Positions& b, double factor, int first, int last, const float* x) const;
  void forward_branch(int branch, float* x) const;
  void backward_branch(int branch, float* x) const;
  void collect_top(float* x) const;
  void forward_top(const Team& team, Workspace& work) const;
  void backward_top(const Team& team, Workspace& work) const;

  std::shared_ptr<const TilePlan> plan_;
  const TileKernels& kernels_;
  AlignedBuffer<std::byte> tiles_;
  std::vector<TileSupernode> supernodes_;
  double scale_;                ///< Scaling::of_all
  std::vector<float> scaling_;  ///< Scaling::of_each, in the factor's order
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> idle_;
  mutable TeamPace pace_;
};

}  // namespace arap
