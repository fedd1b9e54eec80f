// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

namespace arap {

/// Instruction sets that the kernels are compiled for.
enum class Isa {
  kBaseline,  ///< what every processor of the architecture has: SSE2 on x86-64, NEON on arm64
  kAvx2,      ///< with FMA
  kAvx512,    ///< F, DQ and VL
};

/// As ARAP_ISA names it: baseline, avx2, avx512.
[[nodiscard]] std::string_view name(Isa isa);

/// What this machine runs and this build has, the slowest first.
[[nodiscard]] std::vector<Isa> available_isas();

/// The fastest available, or what the environment variable ARAP_ISA says. Throws InvalidInput where the machine does
/// not have that.
[[nodiscard]] Isa choose_isa();

}  // namespace arap
