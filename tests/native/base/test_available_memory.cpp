// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/available_memory.h"

#include <gtest/gtest.h>

#include <limits>

#include "arap/error.h"
#include "support/helpers.h"

#if defined(__linux__)
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace arap_test {
namespace {

using arap::available_memory;

/// The files of a system that tell how much memory there is.
class System {
 public:
  System() { std::filesystem::remove_all(root_); }
  ~System() { std::filesystem::remove_all(root_); }
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  void write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  [[nodiscard]] size_t available() const { return available_memory(root_.string()); }

 private:
  std::filesystem::path root_ =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST(AvailableMemory, IsTheLargestNumberIfNothingIsKnown) {
  EXPECT_EQ(System().available(), std::numeric_limits<size_t>::max());
}

TEST(AvailableMemory, IsThatOfTheMachineWithItsSwapSpace) {
  const System system;
  system.write("proc/meminfo", "MemTotal: 900 kB\nMemFree: 100 kB\nMemAvailable: 300 kB\nSwapFree: 50 kB\n");
  EXPECT_EQ(system.available(), 350 * 1024);
}

TEST(AvailableMemory, IsWhatTheNarrowestControlGroupLeaves) {
  const System system;
  system.write("proc/meminfo", "MemAvailable: 300 kB\n");
  system.write("proc/self/cgroup", "0::/outer/inner\n");
  system.write("sys/fs/cgroup/outer/inner/memory.max", "max\n");
  system.write("sys/fs/cgroup/outer/inner/memory.current", "7\n");
  system.write("sys/fs/cgroup/outer/memory.max", "1000\n");
  system.write("sys/fs/cgroup/outer/memory.current", "400\n");
  system.write("sys/fs/cgroup/outer/memory.stat", "anon 300\nfile 90\ninactive_file 30\nactive_file 20\n");
  EXPECT_EQ(system.available(), 650);
}

TEST(AvailableMemory, OfControlGroupsOfTheFirstVersionToo) {
  const System system;
  system.write("proc/self/cgroup", "9:name=systemd:/\n4:memory:/made/by/another\n0::/\n");
  // A container shows only the top.
  system.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "1000\n");
  system.write("sys/fs/cgroup/memory/memory.usage_in_bytes", "1200\n");
  system.write("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 500\ntotal_active_file 40\n");
  EXPECT_EQ(system.available(), 340);
}

TEST(AvailableMemory, IsWhatTheLimitOfTheProcessLeaves) {
  const System system;
  system.write("proc/self/statm", "1000 10 5\n");
  rlimit former{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &former), 0);
  constexpr rlim_t kLimit = rlim_t{1} << 46U;
  if (former.rlim_max < kLimit) GTEST_SKIP() << "this process has a limit of its own";
  const rlimit limit{kLimit, former.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  const size_t available = system.available();
  ASSERT_EQ(setrlimit(RLIMIT_AS, &former), 0);
  EXPECT_EQ(available, kLimit - 1000 * static_cast<size_t>(sysconf(_SC_PAGESIZE)));
}

TEST(RequireMemory, SaysHowMuchIsNeededAndWhatToDo) {
  arap::require_memory(1e6, "this mesh");
  expect_error<arap::NotEnoughMemory>(
      [] { arap::require_memory(12.5e12, "this mesh"); },
      {"this mesh needs about 12500 GB of memory, but there are only", "close other programs"});
}

}  // namespace
}  // namespace arap_test
#endif
