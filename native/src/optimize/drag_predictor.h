// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/types.h"
#include "parallel/workers.h"

namespace arap {

/// How the forces of the cells, the b of K p' = b, will have changed by the next frame of a drag: on from the last
/// frame as its first iteration turned the cells, by as much as the targets go on in their direction. What few
/// iterations a frame leave to be done is much the same in every frame; begun ahead by it, a drag does not lag behind
/// its handles. The first iteration alone: what later ones and frames at rest bring is catching up, which does not go
/// on.
///
/// Forces and not rotations, because a global step takes them as they are: nothing has to be summed over the cells.
class DragPredictor {
 public:
  /// By which part of the last change the next frame begins ahead: how far its targets go in the direction of the last
  /// ones, as a part of these, in [-1.5, 1.5]. 0 where nothing is known, or nothing moves.
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
  void forget() { last_step_.resize(0, 3); }

 private:
  /// (n, 3), rounded: a step has few digits anyway.
  using Forces = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

  Positions last_step_;
  Forces change_;
  Forces observed_;
};

}  // namespace arap
