// SPDX-License-Identifier: GPL-3.0-or-later
// Bends a bar that is cut into tetrahedra.
#include <arap/tet_arap.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "shapes.h"

namespace {

constexpr std::array<int, 3> kCubes = {24, 4, 4};
/// From a point of the grid to the next one along each axis.
constexpr std::array<int, 3> kSteps = {(kCubes[1] + 1) * (kCubes[2] + 1), kCubes[2] + 1, 1};

/// Each cube is cut into six tetrahedra, the ways along its edges from its lowest to its highest corner.
arap::TetMesh bar() {
  arap::Positions positions((kCubes[0] + 1) * kSteps[0], 3);
  std::vector<arap::TetMesh::Tet> tets;
  for (int v = 0; v < positions.rows(); ++v) {
    const std::array<int, 3> at = {v / kSteps[0], v / kSteps[1] % (kCubes[1] + 1), v % (kCubes[2] + 1)};
    positions.row(v) << at[0] / 4., at[1] / 4., at[2] / 4.;
    if (at[0] == kCubes[0] || at[1] == kCubes[1] || at[2] == kCubes[2]) continue;
    std::array<int, 3> way = {1, kSteps[1], kSteps[0]};
    do {
      tets.push_back({v, v + way[0], v + way[0] + way[1], v + way[0] + way[1] + way[2]});
    } while (std::next_permutation(way.begin(), way.end()));
  }
  return {std::move(positions), std::move(tets)};
}

double volume(const arap::TetMesh::Tet& tet, const arap::Positions& positions) {
  arap::Matrix3 edges;
  for (int k = 0; k < 3; ++k) edges.row(k) = positions.row(tet[k + 1]) - positions.row(tet[0]);
  return edges.determinant() / 6;
}

}  // namespace

int main() {
  const arap::TetMesh mesh = bar();
  const examples::HeldEnds ends(mesh.positions());
  arap::TetArap model(mesh);
  model.set_constraints(ends.constraints());

  const arap::Matrix3 turn = examples::turn(90, arap::Vector3::UnitZ());
  const arap::SolveResult result = model.solve(ends.targets(mesh.positions(), turn, {3, 0, 0}));
  double before = 0;
  double after = 0;
  int n_inside_out = 0;
  for (const arap::TetMesh::Tet& tet : mesh.tets()) {
    before += volume(tet, mesh.positions());
    after += volume(tet, result.positions);
    n_inside_out += volume(tet, result.positions) <= 0 ? 1 : 0;
  }
  std::printf("%d tetrahedra, %d iterations, %s\n", mesh.n_tets(), result.iterations,
              result.stop_reason == arap::StopReason::kConverged ? "converged" : "not at its end");
  std::printf("%.1f%% of the volume, %d turned inside out\n", 100 * after / before, n_inside_out);
}
