// SPDX-License-Identifier: GPL-3.0-or-later
#include "isa.h"

#include <cstdlib>
#include <string>

#include "arap/error.h"
#include "text.h"

namespace arap {

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
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    isas.push_back(Isa::kAvx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
      isas.push_back(Isa::kAvx512);
  }
#endif
  return isas;
}

Isa choose_isa() {
  const std::vector<Isa> isas = available_isas();
  const char* forced = std::getenv("ARAP_ISA");  // NOLINT(concurrency-mt-unsafe): nothing here sets variables
  if (forced == nullptr || *forced == '\0') return isas.back();
  std::string names;
  for (const Isa isa : isas) {
    if (name(isa) == forced) return isa;
    names += names.empty() ? "" : ", ";
    names += name(isa);
  }
  throw InvalidInput(text("ARAP_ISA = ", forced, ", must be one of what this machine has: ", names));
}

}  // namespace arap
