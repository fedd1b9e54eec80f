// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/types.h"
#include "cell_passes.h"
#include "workers.h"

namespace arap {

/// How the cells will have turned by the next frame of a drag: on from the last frame as its first iteration turned
/// them, by as much as the targets go on in their direction. What few iterations a frame leave to be done is much the
/// same in every frame; begun ahead by it, a drag does not lag behind its handles. The first iteration alone: what
/// later ones and frames at rest bring is catching up, which does not go on.
class TurnPrediction {
 public:
  /// A frame is done. Where its targets were at rest, there is nothing to learn.
  /// @param step    of its targets, (n_targets, 3); no rows: they did not come from a frame before
  /// @param before  the rotations of the frame before; left with others, as is `after`
  /// @param after   those after its first iteration
  void learn(const Positions& step, Rotations& before, Rotations& after);

  /// By which part of these turns the next frame begins ahead: how far its targets go in the direction of the last
  /// ones, as a part of these, in [-1.5, 1.5]. 0 where nothing is known, or nothing moves.
  /// @param step  of its targets
  [[nodiscard]] double share(const Positions& step) const;

  /// @param rotations  of the last frame; become those with which the next one begins. A cell turns by pi / 8 at most:
  ///                   one that has snapped to another place does not do it again.
  void apply(double share, const Workers& workers, Rotations& rotations) const;

 private:
  Positions last_step_;
  Rotations before_;
  Rotations after_;
};

}  // namespace arap
