// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/types.h"

namespace arap::bench {

/// Vertices of a bumpy torus of quads, about `n_vertices`: n_around rings of n_across vertices each, ring after ring,
/// with n_around = 3 n_across. Around the z axis, outer radius about 1.3.
struct BumpyTorus {
  explicit BumpyTorus(int n_vertices);

  int n_around;
  int n_across;
  Positions positions;
};

}  // namespace arap::bench
