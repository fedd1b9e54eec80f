// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "aligned_buffer.h"
#include "kernels.h"
#include "linear_solver.h"
#include "team.h"
#include "tile_plan.h"

namespace arap {

/// A factor as tiles, and the solve: elimination up the tree, back substitution down.
class TileFactorization final : public Factorization {
 public:
  /// @param scale  the tiles are of the matrix times this
  TileFactorization(std::shared_ptr<const TilePlan> plan, const TileKernels& kernels, AlignedBuffer<float> tiles,
                    const std::vector<char>& is_erased, double scale);

  void solve(Positions& b) const override;

 private:
  /// What one solve writes to; solves may run at the same time.
  struct Workspace {
    explicit Workspace(const TilePlan& plan);

    AlignedBuffer<float> x;                       ///< (n_places, 4)
    std::vector<AlignedBuffer<float>> of_thread;  ///< b1 of a shared supernode, then x1
    std::vector<double> largest;                  ///< |b| of each thread's part
    std::atomic<int> next_forward = 0;
    std::atomic<int> next_backward = 0;
  };

  void solve_in_team(const Team& team, Positions& b, Workspace& work) const;
  void read_columns(const Positions& b, double factor, int begin, int end, float* x) const;
  void write_columns(Positions& b, double factor, int begin, int end, const float* x) const;
  void forward_branch(int branch, float* x) const;
  void backward_branch(int branch, float* x) const;
  void collect_top(float* x) const;
  void forward_top(const Team& team, Workspace& work) const;
  void backward_top(const Team& team, Workspace& work) const;
  [[nodiscard]] static double largest_entry(const Positions& b, int begin, int end);

  std::shared_ptr<const TilePlan> plan_;
  const TileKernels& kernels_;
  AlignedBuffer<float> tiles_;
  std::vector<TileSupernode> supernodes_;
  std::vector<char> is_erased_;  ///< in the factor's order
  double scale_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> idle_;
};

}  // namespace arap
