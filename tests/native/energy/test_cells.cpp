// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cells.h"

#include <gtest/gtest.h>

#include <cmath>

#include "models/surface_arap/surface_model.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::SplitVector;

TEST(SplitVector, KeepsFortyDigitsOfNumbersOfAnySize) {
  Random random(7);
  for (int k = 0; k < 2000; ++k) {
    Vector3 v = random.vector(1);
    for (double& x : v) x *= std::ldexp(1.0, static_cast<int>(random.uniform(-120, 120)));
    const Vector3 kept = SplitVector(v).whole();
    for (int i = 0; i < 3; ++i) EXPECT_LE(std::abs(kept[i] - v[i]), 0x1p-39 * std::abs(v[i])) << v[i];
  }
}

TEST(SplitVector, KeepsFloatsAndNumbersBesidePowersOfTwo) {
  for (const double x : {0.0, 1.0, -1.0, static_cast<double>(.1F), std::ldexp(1.0, 100)})
    EXPECT_EQ(SplitVector(Vector3::Constant(x)).whole(), Vector3::Constant(x)) << x;
  for (const double x : {1 - 0x1p-26, 1 + 0x1p-26, 1 - 0x1p-25, 1 + 0x1p-24, 2 - 0x1p-25})
    EXPECT_LE(std::abs(SplitVector(Vector3::Constant(x)).whole()[0] - x), 0x1p-39) << x;
}

TEST(Cells, LargeCellsFillUpNoSmallOnes) {
  // The nodes at the edge that all triangles share have all vertices in their cells, the others some ten.
  Random random(3);
  MeshData fan;
  for (int k = 0; k < 3000; ++k) fan.add_vertex(random.vector(1));
  for (int k = 2; k < 3000; ++k) fan.faces.push_back({0, 1, k});
  arap::SurfaceModel model;
  arap::prepare_surface(model, in_model_space(fan).mesh(), {}, {}, {}, {});
  const arap::Cells& cells = model.prepared.energy.cells;
  EXPECT_LT(16 * cells.by_cell().n_groups(), 4 * static_cast<int>(cells.n_incidences()));
}

}  // namespace
}  // namespace arap_test
