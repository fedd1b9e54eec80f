// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap::bench {

/// A torus of quads with bumps, of about `n_vertices` vertices: n_around rings of n_across vertices each, ring after
/// ring, three times as many around as across. Around the z axis, outer radius about 1.3.
struct BumpyTorus {
  explicit BumpyTorus(int n_vertices);

  [[nodiscard]] PolygonMesh mesh() const;

  /// The vertices of `n_rings` rings, from ring `first` on.
  [[nodiscard]] std::vector<int> rings(int first, int n_rings) const;

  int n_around;
  int n_across;
  Positions positions;
};

}  // namespace arap::bench
