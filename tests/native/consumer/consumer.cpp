// SPDX-License-Identifier: GPL-3.0-or-later
// What a program that uses the installed library looks like: a strip, one end held, the other lifted.
#include <arap/surface_arap.h>

#include <cmath>
#include <cstdio>
#include <vector>

int main() {
  constexpr int kColumns = 9;  // of two vertices each
  arap::Positions rest(2 * kColumns, 3);
  for (int column = 0; column < kColumns; ++column) {
    rest.row(2 * column) << column, 0, 0;
    rest.row(2 * column + 1) << column, 1, 0;
  }
  std::vector<int> corner_vertices;
  for (int column = 0; column + 1 < kColumns; ++column) {
    const int v = 2 * column;
    corner_vertices.insert(corner_vertices.end(), {v, v + 2, v + 3, v + 1});
  }
  const arap::PolygonMesh mesh(rest, corner_vertices, std::vector<int>(kColumns - 1, 4));

  arap::SurfaceArap model(mesh);
  const int last = 2 * kColumns - 1;
  model.set_constraints({.vertices = {0, 1, last - 1, last}, .strengths = {1, 1, 1, 1}, .patches = {}});

  arap::Positions targets(4, 3);
  targets << rest.row(0), rest.row(1), rest.row(last - 1), rest.row(last);
  targets.bottomRows(2).col(2).array() += 2;
  const arap::SolveResult result = model.solve(targets);

  const bool holds = (result.positions.row(last) - targets.row(3)).norm() < 1e-9;
  const bool is_between = result.positions(kColumns, 2) > 0.1 && result.positions(kColumns, 2) < 1.9;
  std::printf("arap %s: %d iterations, energy %g -> %g\n", ARAP_VERSION, result.iterations, result.energy_before,
              result.energy_after);
  return holds && is_between && result.energy_after <= result.energy_before ? 0 : 1;
}
