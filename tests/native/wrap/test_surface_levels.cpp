// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_levels.h"

#include <gtest/gtest.h>

#include "parallel/meter.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

TEST(SurfaceLevels, TellAllOfTheirPartOfTheMeter) {
  const MeshData mesh = bumpy_sphere(3);
  double told = 0;
  const arap::Progress progress = [&](double fraction) {
    told = fraction;
    return true;
  };
  arap::Meter meter(progress, "");
  const arap::SurfaceLevels levels(mesh.mesh(), mesh.positions(), 1, {&meter, .5});
  meter.tell();
  EXPECT_GT(levels.size(), 2);
  EXPECT_NEAR(told, .5, 1e-12);
}

}  // namespace
}  // namespace arap_test
