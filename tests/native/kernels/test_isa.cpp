// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels/isa.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Isa;

/// Sets ARAP_ISA and puts the old value back.
class Forced {
 public:
  explicit Forced(const std::string& value) {
    if (const char* old = std::getenv("ARAP_ISA")) old_ = old;
    setenv("ARAP_ISA", value.c_str(), 1);
  }
  Forced(const Forced&) = delete;
  Forced& operator=(const Forced&) = delete;
  ~Forced() { setenv("ARAP_ISA", old_.c_str(), 1); }

 private:
  std::string old_;
};

TEST(Isa, BaselineIsAlwaysThere) { EXPECT_EQ(arap::available_isas().front(), Isa::kBaseline); }

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
