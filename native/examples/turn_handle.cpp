// SPDX-License-Identifier: GPL-3.0-or-later
// Poisson editing: the turn of a handle spreads over a tube, by one linear solve. It has to be told: a move is none.
#include <arap/poisson_editing.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "shapes.h"

int main() {
  const arap::PolygonMesh mesh = examples::tube();
  const arap::Positions& rest = mesh.positions();
  const examples::HeldEnds ends(rest);
  const int middle = examples::between(rest, 2.99, 3.01).front();

  arap::PoissonEditing model(mesh);
  model.set_constraints(ends.constraints());

  const arap::Matrix3 motion = 1.5 * examples::turn(80, arap::Vector3::UnitX());  // a turn, and larger
  const arap::Positions targets = ends.targets(rest, motion);
  for (const bool is_told : {false, true}) {
    std::vector<arap::Matrix3> rotations(ends.pins.size(), arap::Matrix3::Identity());
    rotations.resize(ends.pins.size() + ends.handle.size(), is_told ? motion : arap::Matrix3::Identity());
    const auto vertex = model.solve(targets, {}, rotations).positions.row(middle).eval();
    std::printf("told %s: the middle is turned by %.1f degrees, its radius is %.2f\n",
                is_told ? "the motion of the handle" : "nothing",
                std::atan2(vertex[2], vertex[1]) * 180 / std::numbers::pi, std::hypot(vertex[1], vertex[2]));
  }
}
