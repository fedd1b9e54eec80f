// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels/kernels.h"

namespace arap {

// The sources of the kernels are compiled once for each of these namespaces.
namespace baseline {
FrontKernels front_kernels();
TileKernels tile_kernels();
TileKernels half_tile_kernels();
CellKernels<float> single_cell_kernels();
CellKernels<double> double_cell_kernels();
}  // namespace baseline

#if defined(ARAP_HAS_X86_KERNELS)
namespace avx2 {
FrontKernels front_kernels();
TileKernels tile_kernels();
TileKernels half_tile_kernels();
CellKernels<float> single_cell_kernels();
CellKernels<double> double_cell_kernels();
}  // namespace avx2
namespace avx512 {
FrontKernels front_kernels();
TileKernels tile_kernels();
TileKernels half_tile_kernels();
CellKernels<float> single_cell_kernels();
CellKernels<double> double_cell_kernels();
}  // namespace avx512
#endif

const Kernels& kernels(Isa isa) {
#if defined(ARAP_HAS_X86_KERNELS)
  if (isa == Isa::kAvx512) {
    static const Kernels for_avx512{avx512::front_kernels(), avx512::tile_kernels(), avx512::half_tile_kernels(),
                                    avx512::single_cell_kernels(), avx512::double_cell_kernels()};
    return for_avx512;
  }
  if (isa == Isa::kAvx2) {
    static const Kernels for_avx2{avx2::front_kernels(), avx2::tile_kernels(), avx2::half_tile_kernels(),
                                  avx2::single_cell_kernels(), avx2::double_cell_kernels()};
    return for_avx2;
  }
#else
  static_cast<void>(isa);
#endif
  static const Kernels for_baseline{baseline::front_kernels(), baseline::tile_kernels(), baseline::half_tile_kernels(),
                                    baseline::single_cell_kernels(), baseline::double_cell_kernels()};
  return for_baseline;
}

}  // namespace arap
