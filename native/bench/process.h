// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ctime>
#include <fstream>
#include <string>

namespace arap::bench {

/// Wall-clock and processor milliseconds since construction; processor time is summed over all threads.
class Stopwatch {
 public:
  Stopwatch() : wall_(now(CLOCK_MONOTONIC)), cpu_(now(CLOCK_PROCESS_CPUTIME_ID)) {}
  [[nodiscard]] double ms() const { return now(CLOCK_MONOTONIC) - wall_; }
  [[nodiscard]] double cpu_ms() const { return now(CLOCK_PROCESS_CPUTIME_ID) - cpu_; }

 private:
  static double now(clockid_t clock) {
    timespec t = {};
    clock_gettime(clock, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  }

  double wall_;
  double cpu_;
};

/// Peak resident memory of this program in MB (10^6 bytes). getrusage would include the parent process before exec.
[[nodiscard]] inline double peak_memory_mb() {
  std::ifstream status("/proc/self/status");
  double kib = 0;
  for (std::string word; status >> word;)
    if (word == "VmHWM:") status >> kib;
  return kib * 1024e-6;
}

}  // namespace arap::bench
