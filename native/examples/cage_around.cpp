// SPDX-License-Identifier: GPL-3.0-or-later
// Makes a cage around a tube and bends it: the tube follows at once, since nothing is solved.
#include <arap/cage.h>

#include <cstdio>
#include <utility>

#include "shapes.h"

int main() {
  const arap::PolygonMesh mesh = examples::tube();
  const arap::Positions& rest = mesh.positions();
  const arap::PolygonMesh cage = arap::make_cage(mesh, 12);
  std::printf("a cage of %d vertices and %d quads around %d vertices\n", cage.n_vertices(), cage.n_faces(),
              mesh.n_vertices());

  // Beyond x = 3 all is turned by 40 degrees.
  arap::Positions bent = cage.positions();
  const arap::Matrix3 turn = examples::turn(40, arap::Vector3::UnitZ());
  const Eigen::RowVector3d centre(3, 0, 0);
  for (const int v : examples::between(bent, 3, 9)) bent.row(v) = (bent.row(v) - centre) * turn.transpose() + centre;

  using Coordinates = arap::CageCoordinates;
  for (const auto& [name, coordinates] :
       {std::pair("mean_value", Coordinates::kMeanValue), std::pair("green", Coordinates::kGreen),
        std::pair("harmonic", Coordinates::kHarmonic)}) {
    arap::CageOptions options;
    options.coordinates = coordinates;
    const arap::CageDeformation model(cage, rest, options);
    const arap::Positions posed = model.deform(bent);
    const auto end = posed.bottomRows(1);
    std::printf("%s: end at (%.2f, %.2f), %.0f%% of the volume\n", name, end(0), end(1),
                100 * examples::volume(mesh, posed) / examples::volume(mesh, rest));
  }
}
