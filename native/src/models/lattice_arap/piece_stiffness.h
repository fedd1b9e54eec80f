// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/vertex_properties.h"
#include "lattice/lattice.h"

namespace arap {

/// How much stiffer than normal each piece of a lattice is, (n_pieces,): the geometric mean of its vertices; 1e2 times
/// as much for a vertex in a rigid region, so that what is inside of it bends as little as its surface. A piece without
/// vertices takes the mean of those beside it, from the surface inwards.
/// @param properties  of the vertices of the lattice's mesh; empty: all pieces are normal, and the result is empty
[[nodiscard]] std::vector<double> piece_stiffness(const Lattice& lattice, const VertexProperties& properties);

}  // namespace arap
