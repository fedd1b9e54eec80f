// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/options.h"
#include "arap/types.h"

namespace arap {

/// What a solve did. Energies are as docs/formulation.md defines them, in the square of the input's unit, those of
/// solids (LatticeArap, TetArap) in its cube, and include the soft constraints' terms. If a solve ends in single
/// precision, before it has come near the minimum, they are known to about 1e-7 of the rest energy. An energy beyond
/// the range of numbers is the largest of them.
struct SolveResult {
  Positions positions;       ///< (n, 3), in the space and unit of the rest positions; empty if `out` was given
  double energy_before = 0;  ///< at the start of the iteration, after the initial guess
  double energy_after = 0;   ///< at `positions`; of a cancelled solve, where it was stopped
  int iterations = 0;        ///< done, each a global and a local step; the first global step may be the guess's
  double step = 0;           ///< last iteration's largest movement / rest diagonal
  StopReason stop_reason = StopReason::kMaxIterations;
  /// Connected parts without any constraint: left at rest. If these are a surprise, the mesh may have open seams: see
  /// PolygonMesh::n_parts_joined().
  std::vector<int> parts_at_rest;
  std::vector<int> loose_vertices;  ///< vertices in no face or tetrahedron: left at rest unless constrained
};

}  // namespace arap
