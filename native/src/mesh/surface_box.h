// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>

#include "arap/mesh.h"

namespace arap {

/// Bounding box of the vertices in faces, of all where there are no faces: loose ones neither hide a symmetry nor make
/// the object larger.
[[nodiscard]] Eigen::AlignedBox3d surface_box(const PolygonMesh& mesh);

}  // namespace arap
