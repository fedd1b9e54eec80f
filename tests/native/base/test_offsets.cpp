// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/offsets.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

TEST(MakeOffsets, SumsUpCounts) {
  std::vector<int> offsets{0, 3, 0, 2};
  arap::make_offsets(offsets);
  EXPECT_EQ(offsets, (std::vector<int>{0, 3, 3, 5}));
}

TEST(MakeOffsets, MoreThanIndicesCanCountAreRefused) {
  std::vector<int> offsets{0, 2'000'000'000, 147'483'647};
  arap::make_offsets(offsets);
  EXPECT_EQ(offsets.back(), 2'147'483'647);
  offsets = {0, 2'000'000'000, 2'000'000'000, 2'000'000'000};
  expect_error<arap::InvalidInput>([&] { arap::make_offsets(offsets); }, {"too large", "coarser"});
}

}  // namespace
}  // namespace arap_test
