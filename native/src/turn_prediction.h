// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/types.h"
#include "cell_passes.h"
#include "workers.h"

namespace arap {

/// How the cells will have turned by the next frame of a drag: on from the last frame as they did in it, by as much as
/// the targets go on in their direction. What few iterations a frame leave to be done is much the same in every frame;
/// begun ahead by it, a drag does not lag behind its handles.
class TurnPrediction {
 public:
  /// A frame is done.
  /// @param step    of its targets, (n_targets, 3); no rows: they did not come from a frame before
  /// @param before  the rotations that it began with; left with others
  void learn(const Positions& step, Rotations& before);

  /// By which part of the last frame's turns the next one begins ahead: how far its targets go in the direction of the
  /// last ones, as a part of these, in [-1.5, 1.5]. 0 where nothing is known, or nothing moves.
  /// @param step  of its targets
  [[nodiscard]] double share(const Positions& step) const;

  /// @param rotations  of the last frame; become those with which the next one begins. A cell turns by pi / 8 at most:
  ///                   one that has snapped to another place does not do it again.
  void apply(double share, const Workers& workers, Rotations& rotations) const;

 private:
  Positions last_step_;
  Rotations before_;  ///< with which the last frame began
};

}  // namespace arap
