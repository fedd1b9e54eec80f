// SPDX-License-Identifier: GPL-3.0-or-later
// Poses a surface: one end of a tube is pinned, the other is a handle that swings up. Writes posed_tube.obj.
#include <arap/surface_arap.h>

#include <cstdio>
#include <fstream>
#include <vector>

#include "shapes.h"

namespace {

void write_obj(const char* path, const arap::PolygonMesh& mesh, const arap::Positions& positions) {
  std::ofstream file(path);
  for (const auto& row : positions.rowwise()) file << "v " << row << '\n';
  for (int f = 0; f < mesh.n_faces(); ++f) {
    file << 'f';
    for (const int vertex : mesh.face(f)) file << ' ' << vertex + 1;
    file << '\n';
  }
}

}  // namespace

int main() {
  const arap::PolygonMesh mesh = examples::tube();
  const arap::Positions& rest = mesh.positions();
  const examples::HeldEnds ends(rest);

  arap::SurfaceArap model(mesh);
  model.set_constraints(ends.constraints());

  // Each motion of the handle is a solve, which goes on from the one before.
  arap::SolveResult result;
  for (const int degrees : {30, 60, 90}) {
    const arap::Matrix3 turn = examples::turn(degrees, arap::Vector3::UnitZ());
    result = model.solve(ends.targets(rest, turn, {3, 0, 0}));
    const auto end = result.positions.row(ends.handle.back());
    std::printf("%d degrees: end at (%.2f, %.2f), energy %.4f, %s\n", degrees, end[0], end[1], result.energy_after,
                result.stop_reason == arap::StopReason::kConverged ? "converged" : "not at its end");
  }
  write_obj("posed_tube.obj", mesh, result.positions);
}
