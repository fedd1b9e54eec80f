// SPDX-License-Identifier: GPL-3.0-or-later
// What the code outside of the kernels says to the processor; nothing on processors that are not named here.
#pragma once

#include <cstdint>

namespace arap {

/// Says that this thread waits in a loop.
inline void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ volatile("isb");  // `yield` ends at once on most processors
#endif
}

/// Starts to load the cache line of `address`, which may be no valid one.
inline void prefetch(const void* address) { __builtin_prefetch(address); }

/// Replaces denormal floats by 0 during its lifetime: processors of x86 are slow with them, and a solve makes
/// many far from the support of its right-hand side.
class FlushToZero {
 public:
  FlushToZero() { set(before_ | kFlush); }
  FlushToZero(const FlushToZero&) = delete;
  FlushToZero& operator=(const FlushToZero&) = delete;
  ~FlushToZero() { set(before_); }

 private:
#if defined(__x86_64__)
  using Mode = unsigned;
  static constexpr Mode kFlush = 0x8040;  // of results, and of operands
  static Mode get() { return __builtin_ia32_stmxcsr(); }
  static void set(Mode mode) { __builtin_ia32_ldmxcsr(mode); }
#elif defined(__aarch64__)
  using Mode = std::uint64_t;
  static constexpr Mode kFlush = Mode{1} << 24U;  // of results and operands
  static Mode get() {
    Mode mode = 0;
    __asm__ volatile("mrs %0, fpcr" : "=r"(mode));
    return mode;
  }
  static void set(Mode mode) { __asm__ volatile("msr fpcr, %0" : : "r"(mode) : "memory"); }
#else
  using Mode = unsigned;
  static constexpr Mode kFlush = 0;
  static Mode get() { return 0; }
  static void set(Mode /*mode*/) {}
#endif
  Mode before_ = get();
};

}  // namespace arap
