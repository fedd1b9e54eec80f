// SPDX-License-Identifier: GPL-3.0-or-later
#include "process.h"

#include <fstream>
#include <string>

namespace arap::bench {

double peak_memory_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmHWM:") continue;
    double kib = 0;
    status >> kib;
    return kib * 1024e-6;
  }
  return 0;
}

}  // namespace arap::bench
