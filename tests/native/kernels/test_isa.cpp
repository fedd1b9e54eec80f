// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels/isa.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <string>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Isa;

/// Sets ARAP_ISA and puts the old value back.
class Forced {
 public:
  explicit Forced(const std::string& value) {
    if (const char* old = std::getenv("ARAP_ISA")) old_ = old;
    set(value);
  }
  Forced(const Forced&) = delete;
  Forced& operator=(const Forced&) = delete;
  ~Forced() { set(old_); }

 private:
  static void set(const std::string& value) {
#if defined(_WIN32)
    _putenv_s("ARAP_ISA", value.c_str());
#else
    setenv("ARAP_ISA", value.c_str(), 1);
#endif
  }

  std::string old_;
};

TEST(Isa, BaselineIsAlwaysThere) { EXPECT_EQ(arap::available_isas().front(), Isa::kBaseline); }

constexpr arap::ProcessorFeatures kWithAvx512{.basic = ~0U, .extended = ~0U, .saved = 0xe7};

TEST(Isa, AProcessorWithAvx512RunsAll) {
  EXPECT_EQ(arap::isas_of(kWithAvx512), (std::vector{Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}));
}

/// A system that does not save the registers destroys what is in them.
TEST(Isa, RegistersThatTheSystemDoesNotSaveAreNotUsed) {
  arap::ProcessorFeatures features = kWithAvx512;
  features.saved = 0x07;
  EXPECT_EQ(arap::isas_of(features), (std::vector{Isa::kBaseline, Isa::kAvx2}));
  features.saved = 0x03;
  EXPECT_EQ(arap::isas_of(features), std::vector{Isa::kBaseline});
}

TEST(Isa, WithoutFusedSumsOrHalvesItIsTheBaseline) {
  for (const unsigned bit : {12U, 29U}) {
    arap::ProcessorFeatures features = kWithAvx512;
    features.basic &= ~(1U << bit);
    EXPECT_EQ(arap::isas_of(features), std::vector{Isa::kBaseline}) << bit;
  }
}

#if defined(__linux__) && defined(__x86_64__)
TEST(Isa, WhatTheMachineHasIsWhatLinuxSays) {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line) && !line.starts_with("flags")) continue;
  const auto has_all = [&](std::initializer_list<const char*> names) {
    return std::all_of(names.begin(), names.end(),
                       [&](const char* name) { return (line + ' ').find(std::string(" ") + name + ' ') != line.npos; });
  };
  std::vector expected = {Isa::kBaseline};
  if (has_all({"avx2", "fma", "f16c"})) expected.push_back(Isa::kAvx2);
  if (has_all({"avx2", "fma", "f16c", "avx512f", "avx512dq", "avx512vl"})) expected.push_back(Isa::kAvx512);
  EXPECT_EQ(arap::available_isas(), expected);
}
#endif

TEST(Isa, TheFastestIsTheDefault) {
  const Forced forced("");
  EXPECT_EQ(arap::choose_isa(), arap::available_isas().back());
}

TEST(Isa, EnvironmentForcesOne) {
  for (const Isa isa : arap::available_isas()) {
    const Forced forced{std::string(arap::name(isa))};
    EXPECT_EQ(arap::choose_isa(), isa);
  }
}

TEST(Isa, UnknownOneIsRefusedByName) {
  const Forced forced("mmx");
  expect_error<arap::InvalidInput>([] { static_cast<void>(arap::choose_isa()); },
                                   {"ARAP_ISA = mmx, must be baseline, avx2, avx512, or not set"});
}

TEST(Isa, OneThatTheMachineLacksIsRefusedWithWhatItHas) {
  expect_error<arap::InvalidInput>(
      [] {
        static_cast<void>(arap::choose_isa("avx512", {Isa::kBaseline, Isa::kAvx2}));
      },
      {"ARAP_ISA = avx512, must be what this machine has, baseline, avx2, or not set"});
}

}  // namespace
}  // namespace arap_test
