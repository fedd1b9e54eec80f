// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/constraints.h"
#include "lattice/lattice.h"

namespace arap {

/// The rigid core of a segment: the pieces whose inside it passes through, part by part, in ascending order. Where
/// segments meet, the mesh bends: an end that is inside is not in the core, for 1.2 times its distance from the surface
/// or 40 % of the segment, whichever is less. Empty only if the segment passes through nothing that is inside.
[[nodiscard]] std::vector<int> segment_core(const Lattice& lattice, const Segment& segment);

}  // namespace arap
