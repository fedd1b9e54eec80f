// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

namespace arap {

/// Instruction sets that the kernels are compiled for.
enum class Isa {
  kBaseline,  ///< of every processor of the architecture: SSE2 on x86-64, NEON on arm64
  kAvx2,      ///< with FMA
  kAvx512,    ///< F, DQ and VL
};

/// Its name in ARAP_ISA: baseline, avx2, avx512.
[[nodiscard]] std::string_view name(Isa isa);

/// What an x86-64 processor and its system say of themselves.
struct ProcessorFeatures {
  unsigned basic = 0;     ///< ecx of CPUID 1
  unsigned extended = 0;  ///< ebx of CPUID 7
  unsigned saved = 0;     ///< XCR0: the registers that the system keeps for each thread
};

/// The instruction sets that a processor can run, the slowest first.
[[nodiscard]] std::vector<Isa> isas_of(const ProcessorFeatures& features);

/// Instruction sets of this machine that this build has, the slowest first.
[[nodiscard]] std::vector<Isa> available_isas();

/// The one named `wanted`, the value of ARAP_ISA, or the fastest of `available` if that is empty. Throws InvalidInput
/// if there is no such instruction set or `available` lacks it.
[[nodiscard]] Isa choose_isa(std::string_view wanted, const std::vector<Isa>& available);

/// The same for available_isas() and the environment variable ARAP_ISA.
[[nodiscard]] Isa choose_isa();

}  // namespace arap
