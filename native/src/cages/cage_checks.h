// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/mesh.h"

namespace arap {

/// What a mesh must be to have an inside and an outside. Throws InvalidInput: no faces or size, a face of more than
/// four corners, an edge that as many faces do not run along in one direction as in the other.
void require_closed_cage(const PolygonMesh& mesh);

}  // namespace arap
