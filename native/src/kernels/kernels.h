// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "kernels/cage_kernels.h"
#include "kernels/cell_kernels.h"
#include "kernels/front_kernels.h"
#include "kernels/isa.h"
#include "kernels/lattice_kernels.h"
#include "kernels/tile_kernels.h"
#include "kernels/wrap_kernels.h"

namespace arap {

/// The inner loops for one instruction set.
struct Kernels {
  FrontKernels front;
  TileKernels tile;
  TileKernels half_tile;  ///< all null if the instruction set cannot convert halves
  CellKernels<float> single_cell;
  CellKernels<double> double_cell;
  CubeKernels<float> single_cube;
  CubeKernels<double> double_cube;
  LatticeKernels lattice;
  CageKernels cage;
  WrapKernels wrap;
};

[[nodiscard]] const Kernels& kernels(Isa isa);

}  // namespace arap
