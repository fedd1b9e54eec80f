// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/types.h"
#include "parallel/workers.h"

namespace arap {

/// Extrapolates the forces of the cells, the b of K p' = b, to the next frame of a drag. During a drag the unfinished
/// part of the solve is nearly the same every frame; extrapolating it removes the lag. The change that counts is that
/// of a frame's first iteration, scaled by how far the targets go on in their direction: later iterations, and frames
/// at rest, only catch up.
///
/// It extrapolates forces, not rotations: a global step takes them as they are, and nothing is summed over the cells.
class DragPredictor {
 public:
  /// The part of the last change that the next frame starts ahead: how far its targets go in the direction of the last
  /// ones, as a part of these, in [-1.5, 1.5]. 0 if nothing is known, or nothing moves.
  /// @param step  of its targets, (n_targets, 3); no rows: they did not come from a frame before
  [[nodiscard]] double share(const Positions& step) const;

  /// Adds what is ahead to a residual, (n, 3).
  void add_to(Positions& residual, double share, const Workers& workers) const;

  /// The change of the forces by the first fit of a frame. That began with K p' = b + share * (last change), so what
  /// the fit leaves as residual, b_new - K p', is the change but for that share.
  /// @param residual  after the fit, (n, 3); what it is at vertices that the matrix does not move has no meaning
  void observe(const Positions& residual, double share, const Workers& workers);
  /// The frame is done: what was observed in it is the last change, unless that is not finite (forces may be beyond the
  /// range of a float). Then there is none.
  /// @param step  of its targets
  void learn(const Positions& step, const Workers& workers);
  /// The frame has no predecessor.
  void forget() noexcept { *this = {}; }

 private:
  /// (n, 3), rounded: a step has few digits anyway.
  using Forces = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

  Positions last_step_;
  Forces change_;
  Forces observed_;
};

}  // namespace arap
