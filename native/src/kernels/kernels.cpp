// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels/kernels.h"

namespace arap {

// The sources of the kernels are compiled once for each instruction set, in the namespace of its name.
#define ARAP_KERNELS_OF(isa)                                                                            \
  namespace isa {                                                                                       \
  FrontKernels front_kernels();                                                                         \
  TileKernels tile_kernels();                                                                           \
  TileKernels half_tile_kernels();                                                                      \
  CellKernels<float> single_cell_kernels();                                                             \
  CellKernels<double> double_cell_kernels();                                                            \
  CubeKernels<float> single_cube_kernels();                                                             \
  CubeKernels<double> double_cube_kernels();                                                            \
  LatticeKernels lattice_kernels();                                                                     \
  CageKernels cage_kernels();                                                                           \
  WrapKernels wrap_kernels();                                                                           \
  static const Kernels& kernels() {                                                                     \
    static const Kernels                                                                                \
        all{front_kernels(),       tile_kernels(),        half_tile_kernels(),   single_cell_kernels(), \
            double_cell_kernels(), single_cube_kernels(), double_cube_kernels(), lattice_kernels(),     \
            cage_kernels(),        wrap_kernels()};                                                     \
    return all;                                                                                         \
  }                                                                                                     \
  }

ARAP_KERNELS_OF(baseline)
#if defined(ARAP_HAS_X86_KERNELS)
ARAP_KERNELS_OF(avx2)
ARAP_KERNELS_OF(avx512)
#endif

const Kernels& kernels([[maybe_unused]] Isa isa) {
#if defined(ARAP_HAS_X86_KERNELS)
  if (isa == Isa::kAvx512) return avx512::kernels();
  if (isa == Isa::kAvx2) return avx2::kernels();
#endif
  return baseline::kernels();
}

}  // namespace arap
