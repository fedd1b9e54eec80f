// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "arap/tet_arap.h"
#include "constraints/prepared_model.h"
#include "parallel/meter.h"

namespace arap {

/// Fills in the energy of tetrahedra, E = sum_t V_t s_t |F_t - R_t|^2 [CPSS10], one cell a tetrahedron. With g_j the
/// gradients of the linear functions that are 1 at vertex j, F = sum_j p'_j g_j^T, so
///
///     V |F - R|^2 = V |F|^2 - 2 V <R, F> + 3 V:  K_jk = 2 V s <g_j, g_k>, q_j = 2 V s g_j, E_0 = 3 V s.
///
/// @param rest              (n, 3)
/// @param tets              not flat; throws InvalidInput that names one of which rounding leaves nothing
/// @param stiffness         (n,) of vertices, or empty: all 1; s_t is the geometric mean
/// @param region_of_vertex  (n,) rigid region or -1, or empty: who is the home of a cell
/// @param find_order        as for assemble_lattice_energy()
void assemble_tet_energy(CellEnergy& energy, const Positions& rest, const std::vector<TetMesh::Tet>& tets,
                         const std::vector<double>& stiffness, const std::vector<int>& region_of_vertex, int threads,
                         const MeterPart& meter, const std::function<const std::vector<int>*()>& find_order);

/// The assembler of tetrahedra: energy, regions, and a solver for the pattern of its system, in whose order the
/// vertices are numbered.
/// @param model  has the rest positions, centred, of size 1
/// @return       the model's number of each vertex, (n,)
/// Throws Cancelled.
std::vector<int> prepare_tets(PreparedModel& model, const TetMesh& mesh, const TetOptions& options,
                              const VertexProperties& properties, const Progress& progress);

}  // namespace arap
