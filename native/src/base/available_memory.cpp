// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/available_memory.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "arap/error.h"
#include "base/format_message.h"

#if defined(__GLIBC__)
#include <malloc.h>
#endif
#if defined(__linux__)
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace arap {

namespace {

namespace fs = std::filesystem;

constexpr size_t kUnknown = std::numeric_limits<size_t>::max();

#if defined(__linux__)

/// The number after a word in a file, or its first one; kUnknown if there is none ("max" in a control group).
size_t number_in(const fs::path& path, const std::string& word = "") {
  std::ifstream file(path);
  for (std::string read; !word.empty() && file >> read && read != word;) continue;
  size_t number = 0;
  return file >> number ? number : kUnknown;
}

/// What a control group leaves. The kernel gives up copies of files when memory is needed, those in use last, and
/// counts them as available in a whole machine's MemAvailable. What a process keeps in shared memory is not among them.
/// @param prefix  of the numbers that include the groups below
size_t left_in_group(const fs::path& group, const char* limit_name, const char* usage_name, const std::string& prefix) {
  const size_t limit = number_in(group / limit_name);
  size_t used = number_in(group / usage_name);
  if (limit == kUnknown || used == kUnknown) return kUnknown;
  for (const char* files : {"active_file", "inactive_file"}) {
    const size_t given_up = number_in(group / "memory.stat", prefix + files);
    if (given_up != kUnknown) used -= std::min(used, given_up);
  }
  return limit - std::min(limit, used);
}

/// The least that the process' control groups and those above them leave. A container may show only the top of them.
size_t left_in_groups(const fs::path& root) {
  size_t least = kUnknown;
  std::ifstream file(root / "proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const bool is_second_version = line.starts_with("0::/");
    const size_t memory = line.find(":memory:/");
    if (!is_second_version && memory == std::string::npos) continue;
    const fs::path top = root / (is_second_version ? "sys/fs/cgroup" : "sys/fs/cgroup/memory");
    for (fs::path group = line.substr(line.find('/') + 1);; group = group.parent_path()) {
      least = std::min(least, is_second_version ? left_in_group(top / group, "memory.max", "memory.current", "")
                                                : left_in_group(top / group, "memory.limit_in_bytes",
                                                                "memory.usage_in_bytes", "total_"));
      if (group.empty()) break;
    }
  }
  return least;
}

size_t left_of_own_limit(const fs::path& root) {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnknown;
  const size_t pages = number_in(root / "proc/self/statm");
  if (pages == kUnknown) return kUnknown;
  const size_t used = pages * static_cast<size_t>(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur - std::min<size_t>(limit.rlim_cur, used);
}

size_t left_in_machine(const fs::path& root) {
  constexpr size_t kKib = 1024;
  const size_t free = number_in(root / "proc/meminfo", "MemAvailable:");
  const size_t swap = number_in(root / "proc/meminfo", "SwapFree:");
  return free == kUnknown ? kUnknown : kKib * (free + (swap == kUnknown ? 0 : swap));
}

#endif

std::string amount(double bytes) {
  return bytes < 1e9 ? text(std::round(1e-6 * bytes), " MB") : text(std::round(1e-8 * bytes) / 10, " GB");
}

}  // namespace

size_t available_memory([[maybe_unused]] const std::string& root) {
#if defined(__linux__)
  return std::min({left_of_own_limit(root), left_in_groups(root), left_in_machine(root)});
#else
  return kUnknown;
#endif
}

void return_freed_memory() {
#if defined(__GLIBC__)  // others do so themselves
  malloc_trim(0);
#endif
}

void require_memory(double bytes, const std::string& what) {
  // Reading files takes a while, and smaller amounts decide nothing.
  constexpr double kMuch = 50e6;
  if (bytes < kMuch) return;
  const auto available = static_cast<double>(available_memory());
  if (bytes <= available) return;
  throw NotEnoughMemory(text(what, " needs about ", amount(bytes), " of memory, but there are only ", amount(available),
                             "; close other programs or take a coarser mesh"));
}

}  // namespace arap
