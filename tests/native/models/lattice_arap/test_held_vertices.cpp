// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/held_vertices.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "models/lattice_arap/lattice_energy.h"
#include "optimize/engine.h"
#include "sampling/surface_patch.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::HeldVertices;
using arap::Lattice;

/// How far the lattice by itself leaves held vertices from their targets at the most, before anything makes them exact.
double left_by_lattice(const MeshData& mesh, const Task& task, double cube_size, const std::vector<double>& areas) {
  const Lattice lattice(mesh.mesh(), cube_size);
  arap::PreparedModel model;
  arap::assemble_lattice_energy(model.energy, lattice, {}, 1, {}, [] { return nullptr; });
  model.rest = lattice.rest();
  model.part_of_vertex = lattice.part_of_control_point();
  model.n_parts = mesh.mesh().n_parts();
  model.solver = model.make_solver();
  model.keep_numbers();
  const HeldVertices held(lattice, areas, task.constraints);
  arap::Engine engine(model);
  engine.take(engine.prepare({{}, held.rows()}, {}));
  engine.solve(held.targets(task.targets), to_accuracy(1e-6), {}, {}, [](const Positions&) { return true; });
  Positions points = mesh.positions();
  lattice.embed(engine.positions(), arap::Workers(1), points);
  return max_distance(values_of(task.constraints, points), task.targets);
}

/// Of diagonal 1; the lower part is held.
MeshData ball(int levels) { return in_unit_size(icosphere(levels)); }

Task hold_low(const MeshData& mesh) {
  Task task;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.vertices[v][2] < -.15) task.add(v, mesh.vertices[v]);
  return task;
}

TEST(HeldVertices, OfARegionAreNearTheirTargets) {
  const MeshData mesh = ball(4);
  Task task = hold_low(mesh);
  const RigidMotion motion{rotation_about(Vector3(1, 2, 0), .8), Vector3(.1, 0, .1)};
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.vertices[v][2] > .2) task.add(v, motion.apply(mesh.vertices[v]));
  EXPECT_LT(left_by_lattice(mesh, task, .05, arap::vertex_areas(mesh.mesh())), 5e-3);
}

/// The surface of one vertex is a hundredth of that on the coarse mesh, or nothing.
TEST(HeldVertices, OneAloneHoldsAsASmallRegionDoesAtEveryDensity) {
  for (const int levels : {2, 3, 5}) {
    const MeshData mesh = ball(levels);
    Task task = hold_low(mesh);
    const int tip = extreme_vertices(mesh.positions(), 2, -1e-9).front();
    task.add(tip, mesh.vertices[tip] + Vector3(0, 0, .1));
    for (const double share : {1.0, 0.0}) {
      std::vector<double> areas = arap::vertex_areas(mesh.mesh());
      for (double& area : areas) area *= share;
      EXPECT_LT(left_by_lattice(mesh, task, .05, areas), .05 * .1) << levels << " " << share;
    }
  }
}

/// The rows' energy is that of the vertices but for a constant.
TEST(HeldVertices, RowsHaveTheEnergyOfTheVertices) {
  const MeshData mesh = ball(3);
  const Lattice lattice(mesh.mesh(), .1);
  Task task;
  for (int v = 0; v < mesh.n_vertices(); v += 3) task.add(v, mesh.vertices[v], v % 2 == 0 ? 1 : .4);
  Random random(5);
  task.targets += random.noise(static_cast<int>(task.targets.rows()), .1);
  const std::vector<double> areas(mesh.n_vertices(), .01);  // more than the side of a cube in each piece
  const HeldVertices held(lattice, areas, task.constraints);
  const Positions targets = held.targets(task.targets);
  const auto of_rows = [&](const Positions& c) {
    double sum = 0;
    for (int r = 0; r < held.rows().size(); ++r)
      sum += held.rows().weights[r] / 2 * (held.rows().rows[r].of(c) - targets.row(r)).squaredNorm();
    return sum;
  };
  const auto of_vertices = [&](const Positions& c) {
    double sum = 0;
    for (size_t k = 0; k < task.constraints.vertices.size(); ++k) {
      const double s = task.constraints.strengths[k];
      const double weight = (s < 1 ? s / (1 - s) : 100) * .01 / .1;
      const Eigen::RowVector3d target = task.targets.row(static_cast<Eigen::Index>(k));
      const Eigen::RowVector3d gap = lattice.row(task.constraints.vertices[k]).of(c) - target;
      sum += weight * gap.squaredNorm();
    }
    return sum;
  };
  const Positions a = lattice.rest();
  const Positions b = a + random.noise(static_cast<int>(a.rows()), .2);
  EXPECT_NEAR(of_rows(b) - of_rows(a), of_vertices(b) - of_vertices(a), 1e-6 * of_vertices(b));
}

}  // namespace
}  // namespace arap_test
