// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels/isa.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "arap/error.h"
#include "base/format_message.h"

#if defined(ARAP_HAS_X86_KERNELS)
#include <cpuid.h>
#endif

namespace arap {

namespace {

constexpr std::array kIsas = {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512};

// Bits of ProcessorFeatures::basic, extended and saved.
constexpr unsigned kSystemSaves = 1U << 27U;
constexpr unsigned kBasicOfAvx2 = kSystemSaves | 1U << 12U | 1U << 28U | 1U << 29U;  // FMA, AVX, F16C
constexpr unsigned kAvx2 = 1U << 5U;
constexpr unsigned kAvx512 = 1U << 16U | 1U << 17U | 1U << 31U;  // F, DQ, VL
constexpr unsigned kSavedOfAvx2 = 0x06;
constexpr unsigned kSavedOfAvx512 = 0xe6;

bool has(unsigned bits, unsigned wanted) { return (bits & wanted) == wanted; }

template <class Isas>
std::string list(const Isas& isas) {
  std::string names;
  for (const Isa isa : isas) {
    names += names.empty() ? "" : ", ";
    names += name(isa);
  }
  return names;
}

#if defined(ARAP_HAS_X86_KERNELS)
/// By instructions, not by __builtin_cpu_supports(): its run-time library is not linked on every system.
ProcessorFeatures features_of_this_machine() {
  ProcessorFeatures features;
  unsigned eax = 0;
  unsigned ebx = 0;
  unsigned edx = 0;
  if (__get_cpuid(1, &eax, &ebx, &features.basic, &edx) == 0 || (features.basic & kSystemSaves) == 0) return features;
  unsigned ecx = 0;
  if (__get_cpuid_count(7, 0, &eax, &features.extended, &ecx, &edx) == 0) features.extended = 0;
  __asm__ volatile("xgetbv" : "=a"(features.saved), "=d"(edx) : "c"(0));
  return features;
}
#endif

}  // namespace

std::string_view name(Isa isa) {
  switch (isa) {
    case Isa::kBaseline:
      return "baseline";
    case Isa::kAvx2:
      return "avx2";
    case Isa::kAvx512:
      return "avx512";
  }
  return "";
}

std::vector<Isa> isas_of(const ProcessorFeatures& features) {
  std::vector<Isa> isas = {Isa::kBaseline};
  if (has(features.basic, kBasicOfAvx2) && has(features.extended, kAvx2) && has(features.saved, kSavedOfAvx2)) {
    isas.push_back(Isa::kAvx2);
    if (has(features.extended, kAvx512) && has(features.saved, kSavedOfAvx512)) isas.push_back(Isa::kAvx512);
  }
  return isas;
}

std::vector<Isa> available_isas() {
#if defined(ARAP_HAS_X86_KERNELS)
  return isas_of(features_of_this_machine());
#else
  return {Isa::kBaseline};
#endif
}

Isa choose_isa(std::string_view wanted, const std::vector<Isa>& available) {
  if (wanted.empty()) return available.back();
  const auto named = std::find_if(kIsas.begin(), kIsas.end(), [&](Isa isa) { return name(isa) == wanted; });
  if (named == kIsas.end())
    throw InvalidInput(text("ARAP_ISA = ", wanted, ", must be ", list(kIsas), ", or not set for the fastest"));
  if (std::find(available.begin(), available.end(), *named) == available.end())
    throw InvalidInput(text("ARAP_ISA = ", wanted, ", must be what this machine has, ", list(available),
                            ", or not set for the fastest"));
  return *named;
}

Isa choose_isa() {
  const char* wanted = std::getenv("ARAP_ISA");  // NOLINT(concurrency-mt-unsafe): nothing here sets variables
  return choose_isa(wanted != nullptr ? wanted : "", available_isas());
}

}  // namespace arap
