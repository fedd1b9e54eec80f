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
/// Conversions of half precision. Not every compiler's __builtin_cpu_supports() knows "f16c".
bool has_f16c() {
  unsigned eax = 0;
  unsigned ebx = 0;
  unsigned ecx = 0;
  unsigned edx = 0;
  return __get_cpuid(1, &eax, &ebx, &ecx, &edx) != 0 && (ecx & bit_F16C) != 0;
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

std::vector<Isa> available_isas() {
  std::vector<Isa> isas = {Isa::kBaseline};
#if defined(ARAP_HAS_X86_KERNELS)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && has_f16c()) {
    isas.push_back(Isa::kAvx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
      isas.push_back(Isa::kAvx512);
  }
#endif
  return isas;
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
