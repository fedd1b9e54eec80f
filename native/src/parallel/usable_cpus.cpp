// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/usable_cpus.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#if defined(ARAP_OPENMP)
#include <omp.h>
#else
#include <thread>
#endif
#if defined(__linux__)
#include <sched.h>
#endif

namespace arap {

namespace {

#if defined(__linux__)
int cpus_of_affinity(int otherwise) {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return otherwise;
  // The other count is 0 if nobody knows it.
  return otherwise > 0 ? std::min(otherwise, CPU_COUNT(&set)) : CPU_COUNT(&set);
}

/// The smallest quota of the process' control group and those above it.
int cpus_of_groups(int otherwise) {
  int n_cpus = otherwise;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    constexpr std::string_view kUnified = "0::";
    if (!line.starts_with(kUnified)) continue;
    for (std::string path = line.substr(kUnified.size());; path.resize(path.rfind('/'))) {
      while (path.ends_with('/')) path.pop_back();
      std::ifstream file("/sys/fs/cgroup" + path + "/cpu.max");
      if (std::string cpu_max; std::getline(file, cpu_max))
        n_cpus = std::min(n_cpus, cpus_of_quota(cpu_max).value_or(n_cpus));
      if (path.find('/') == std::string::npos) break;
    }
  }
  return n_cpus;
}
#endif

}  // namespace

std::optional<int> cpus_of_quota(std::string_view cpu_max) {
  std::istringstream words{std::string(cpu_max)};
  double quota = 0;
  double period = 0;
  if (!(words >> quota >> period) || !(quota > 0) || !(period > 0)) return std::nullopt;
  return static_cast<int>(std::min(std::ceil(quota / period), 1e6));
}

int usable_cpus() {
#if defined(ARAP_OPENMP)
  int n_cpus = omp_get_max_threads();  // heeds OMP_NUM_THREADS
#else
  auto n_cpus = static_cast<int>(std::thread::hardware_concurrency());
#endif
#if defined(__linux__)
  n_cpus = cpus_of_groups(cpus_of_affinity(n_cpus));
#endif
  return std::max(1, n_cpus);
}

}  // namespace arap
