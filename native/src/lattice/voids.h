// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/mesh.h"

namespace arap {

/// The mesh, with each void as one part with the shell around it: a triangle without area joins each vertex of the void
/// with the nearest one of the shell. So the wall between them is what they enclose together. It costs no cubes: see
/// find_pieces.
///
/// A void is a closed part turned the other way than the smallest closed part that it is inside of, unless that is a
/// void itself: what is in a void is another solid, which moves by itself.
/// @param mesh  of diagonal 1
[[nodiscard]] PolygonMesh join_voids(PolygonMesh mesh);

}  // namespace arap
