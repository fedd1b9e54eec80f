// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/cage_arap.h"
#include "arap/mesh.h"
#include "cages/cage_points.h"
#include "constraints/prepared_model.h"
#include "parallel/meter.h"

namespace arap {

/// The assembler of a cage: an energy over its vertices, which keep their numbers. kCage: that of its own surface.
/// kMesh: that of the mesh where p' = Phi c',
///
///     K_c = Phi^T K Phi,   q_c = Phi^T q of each cell,
///
/// and a thousandth of the cage's own, for what the mesh does not feel. Both have rotation nodes.
/// @param model    takes energy, rest and parts; its workers are there
/// @param cage     in model space
/// @param mesh     in model space
/// @param carried  (n_points,) the vertices of the mesh that are the points, ascending: all but the loose ones
/// @param points   of them
/// Throws Cancelled, or NotEnoughMemory.
void assemble_cage_energy(PreparedModel& model, const PolygonMesh& cage, const PolygonMesh& mesh,
                          const std::vector<int>& carried, const CagePoints& points, const CageArapOptions& options,
                          const MeterPart& meter);

}  // namespace arap
