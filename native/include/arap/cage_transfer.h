// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap {
inline namespace ARAP_COMPILED_ALIKE {

/// Moves a cage as another one of the same faces has been moved [CHSB10], by deformation transfer [SP04]. The gradients
/// of the source's triangles (of a quad those of both its diagonals), completed by their normals, whose lengths grow
/// as the root of the area, turn and stretch the edges of the target's; the result is nearest to these. With
/// CageDeformation::fit() before and CageDeformation::deform() after it carries a deformation from one shape to
/// another.
///
/// If the source has moved by a turn, a scale and a shift, the target turns and grows alike, about its own middle: this
/// moves as the source's does. Of several shells each goes as its own in the source: one that did not move stays. The
/// result does not depend on where the target is.
/// @param source        at rest
/// @param moved_source  (n_vertices, 3), finite
/// @param target        at rest, with the source's faces
/// @return  (n_vertices, 3) of the target
/// Throws InvalidInput; Cancelled when `progress` returns false.
[[nodiscard]] Positions transfer_cage(const PolygonMesh& source, const Positions& moved_source,
                                      const PolygonMesh& target, const Progress& progress = {});

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
