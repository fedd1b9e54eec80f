// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/mesh.h"
#include "arap/poisson_editing.h"
#include "constraints/prepared_model.h"
#include "models/poisson_editing/face_forces.h"

namespace arap {

/// A surface for Poisson editing. The prepared model has no cells: only its matrix counts, K = 2 L, with L the
/// Laplacian of cotangents.
struct PoissonModel {
  PreparedModel prepared;
  FaceForces forces;
};

/// Fills in the model, whose vertices get the numbers of its linear solver.
/// @param mesh  in model space: centred, diagonal 1
/// @return  the model's number of each vertex of the mesh, (n,)
/// Throws Cancelled.
std::vector<int> prepare_poisson(PoissonModel& model, const PolygonMesh& mesh, const PoissonOptions& options,
                                 const Progress& progress);

}  // namespace arap
