// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cell_stream.h"

#include <gtest/gtest.h>

#include "kernels/cell_kernels.h"
#include "models/surface_arap/surface_model.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

TEST(CellStream, LargeCellsFillUpNoSmallOnes) {
  // The nodes at the edge that all triangles share have all vertices in their cells, the others some ten.
  Random random(3);
  MeshData fan;
  for (int k = 0; k < 3000; ++k) fan.add_vertex(random.vector(1));
  for (int k = 2; k < 3000; ++k) fan.faces.push_back({0, 1, k});
  arap::SurfaceModel model;
  arap::prepare_surface(model, in_model_space(fan).mesh(), {}, {}, {}, {});
  const arap::CellEnergy& energy = model.prepared.energy;
  const arap::CellStream<float> stream(energy, 1);
  EXPECT_LT(arap::kSliceWidth * stream.cells.n_groups(), 4 * energy.q.rows());
}

}  // namespace
}  // namespace arap_test
