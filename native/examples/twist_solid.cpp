// SPDX-License-Identifier: GPL-3.0-or-later
// Twists a tube by 180 degrees: as a surface it loses volume, with its inside it keeps nearly all.
#include <arap/lattice_arap.h>
#include <arap/surface_arap.h>

#include <cstdio>

#include "shapes.h"

namespace {

/// All models have the same calls.
template <typename Model>
void twist(const char* name, const arap::PolygonMesh& mesh, Model model) {
  const examples::HeldEnds ends(mesh.positions());
  model.set_constraints(ends.constraints());
  arap::Positions posed;
  // In steps: half a turn at once has no shorter way.
  for (const int degrees : {60, 120, 180})
    posed = model.solve(ends.targets(mesh.positions(), examples::turn(degrees, arap::Vector3::UnitX()))).positions;
  std::printf("%s: %.1f%% of the volume\n", name,
              100 * examples::volume(mesh, posed) / examples::volume(mesh, mesh.positions()));
}

}  // namespace

int main() {
  const arap::PolygonMesh mesh = examples::tube();
  twist("surface", mesh, arap::SurfaceArap(mesh));
  twist("solid", mesh, arap::LatticeArap(mesh));
  arap::LatticeOptions options;
  options.keep_volume = 1;
  twist("solid that keeps its volume", mesh, arap::LatticeArap(mesh, options));
}
