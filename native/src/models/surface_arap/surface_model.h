// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "arap/options.h"
#include "constraints/prepared_model.h"

namespace arap {

/// A surface as the engine sees it, and what only a surface has.
struct SurfaceModel {
  PreparedModel prepared;
  std::vector<double> areas;  ///< (n,) of the surface at each vertex
};

/// The assembler of a surface: energy, regions, and a solver for the pattern of its system, in whose order the vertices
/// are numbered.
/// @param mesh              in model space: centred, diagonal 1
/// @param stiffness         (n,) > 0, or empty
/// @param region_of_vertex  (n,) rigid region or -1, or empty
/// @return  the model's number of each vertex of the mesh, (n,)
/// Throws Cancelled.
std::vector<int> prepare_surface(SurfaceModel& model, const PolygonMesh& mesh, const Options& options,
                                 const std::vector<double>& stiffness, const std::vector<int>& region_of_vertex,
                                 const Progress& progress);

}  // namespace arap
