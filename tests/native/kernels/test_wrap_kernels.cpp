// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "base/aligned_buffer.h"
#include "kernels/isa.h"
#include "kernels/kernels.h"

namespace arap_test {
namespace {

/// What was there before is read by what pushes the points of whole blocks.
TEST(WrapKernels, MovesOfPointsLeaveNothingOfWhatWasThere) {
  constexpr int kPoints = 3;
  const std::array<int, kPoints + 1> offsets = {0, 1, 2, 3};
  const std::array<arap::AnchorWeight, kPoints> weights = {{{0, 1}, {0, .5}, {0, 0}}};
  arap::AlignedBuffer<float> maps(arap::kMapNumbers);
  for (int i = 0; i < arap::kMapNumbers; ++i) maps.data()[i] = 1;
  arap::AlignedBuffer<float> points(4 * arap::kWrapBlock);
  for (int i = 0; i < 4 * arap::kWrapBlock; ++i) points.data()[i] = 1;
  arap::AlignedBuffer<float> moves(4 * arap::kWrapBlock);
  for (int i = 0; i < 4 * arap::kWrapBlock; ++i) moves.data()[i] = std::numeric_limits<float>::quiet_NaN();
  arap::kernels(arap::choose_isa())
      .wrap.move_points(offsets.data(), weights.data(), maps.data(), points.data(), moves.data(), 0, kPoints);
  for (int p = 0; p < arap::kWrapBlock; ++p)
    for (int i = 0; i < 4; ++i) {
      const float expected = p < kPoints && i < 3 ? 4 * weights[p].weight : 0;
      EXPECT_EQ(moves.data()[4 * p + i], expected) << p << " " << i;
    }
}

}  // namespace
}  // namespace arap_test
