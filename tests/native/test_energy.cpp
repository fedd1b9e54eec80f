// SPDX-License-Identifier: GPL-3.0-or-later
// SurfaceArap::energy() and its gradient where vertices are not each for themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "helpers.h"

namespace arap_test {
namespace {

using arap::SurfaceArap;

/// Of SurfaceArap::energy, by central differences.
Positions differences(const SurfaceArap& solver, const Positions& p, double h) {
  Positions result(p.rows(), 3);
  for (Eigen::Index v = 0; v < p.rows(); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      Positions forth = p;
      Positions back = p;
      forth(v, axis) += h;
      back(v, axis) -= h;
      result(v, axis) = (solver.energy(forth) - solver.energy(back)) / (2 * h);
    }
  return result;
}

void expect_gradient(const SurfaceArap& solver, const Positions& p, double size, const std::string& what) {
  const Positions gradient = solver.energy_gradient(p);
  EXPECT_LT(max_distance(gradient, differences(solver, p, 1e-5 * size)), 1e-6 * gradient.cwiseAbs().maxCoeff()) << what;
}

TEST(Energy, OfJoinedVerticesTheFirstCounts) {
  const MeshData mesh = cylinder_with_open_seam(8, 3, Faces::kTriangles);
  constexpr int kFirstCopy = 8 * 4;
  for (const Model& model : all_models()) {
    arap::Options options = model.options();
    options.join_seams = true;
    const SurfaceArap solver(mesh.mesh(), options);
    Positions p = mesh.positions() + Random(3).noise(mesh.n_vertices(), .05 * mesh.diagonal());
    expect_gradient(solver, p, mesh.diagonal(), model.name());
    const double energy = solver.energy(p);
    p.bottomRows(mesh.n_vertices() - kFirstCopy).array() += .1;
    EXPECT_EQ(solver.energy(p), energy) << model.name();
  }
}

}  // namespace
}  // namespace arap_test
