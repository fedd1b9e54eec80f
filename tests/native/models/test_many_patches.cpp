// SPDX-License-Identifier: GPL-3.0-or-later
// Hundreds of patches of few vertices: all of them exact, and nothing that grows with the square of their number.
#include <gtest/gtest.h>

#include <vector>

#include "arap/lattice_arap.h"
#include "arap/surface_arap.h"
#include "constraints/prepared_constraints.h"
#include "models/surface_arap/surface_model.h"
#include "support/dense.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

/// The first corners of `n` faces hold what a bend does to them.
Task patches_on(const MeshData& mesh, int n) {
  Task task;
  for (int k = 0; k < n; ++k) {
    const std::vector<int>& face = mesh.faces[static_cast<size_t>(k) * mesh.faces.size() / static_cast<size_t>(n)];
    const std::vector<int> corners(face.begin(), face.begin() + 3);
    const std::vector<double> weights{1, 2, 3};
    Vector3 p = average(mesh.positions(), corners, weights);
    p[2] += .3 * p[0] * p[0];
    p[1] *= 1.1;
    task.add_patch(corners, weights, p);
  }
  return task;
}

double largest_gap(const Task& task, const Positions& positions) {
  const arap::Patches& patches = task.constraints.patches;
  double largest = 0;
  for (int p = 0; p < patches.size(); ++p) {
    const auto begin = static_cast<size_t>(patches.offsets[p]);
    const auto size = static_cast<size_t>(patches.offsets[p + 1]) - begin;
    const Vector3 reached = average(positions, std::span(patches.vertices).subspan(begin, size),
                                    std::span(patches.weights).subspan(begin, size));
    largest = std::max(largest, (reached.transpose() - task.targets.row(p)).norm());
  }
  return largest;
}

TEST(ManyPatches, OfASurfaceAreMetAfterEveryIteration) {
  const MeshData mesh = bumpy_sphere(4);
  const Task task = patches_on(mesh, 1000);
  arap::SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  EXPECT_LT(largest_gap(task, solver.solve(task.targets, iterations(1)).positions), 1e-9);
  EXPECT_LT(largest_gap(task, solver.solve(task.targets, to_accuracy(1e-6)).positions), 1e-9);
}

TEST(ManyPatches, OfASurfaceBalanceItsForces) {
  const MeshData mesh = bumpy_sphere(3);
  const Task task = patches_on(mesh, 150);
  arap::SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  const arap::SolveResult result = solver.solve(task.targets, to_accuracy(1e-9));
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  EXPECT_NEAR(solver.energy(result.positions), result.energy_after, 1e-6 * result.energy_after);
  const Positions gradient = solver.energy_gradient(result.positions);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(mesh.n_vertices(), 150);
  const arap::Patches& patches = task.constraints.patches;
  for (int p = 0; p < patches.size(); ++p)
    for (int k = patches.offsets[p]; k < patches.offsets[p + 1]; ++k)
      rows(patches.vertices[k], p) += patches.weights[k];
  const Eigen::MatrixX3d left = gradient - rows * least_squares(rows, gradient);
  EXPECT_GT(gradient.cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT(left.cwiseAbs().maxCoeff(), 1e-5 * gradient.cwiseAbs().maxCoeff());
}

TEST(ManyPatches, ThatRepeatAndContradictEachOtherMeetInTheMiddle) {
  const MeshData mesh = bumpy_sphere(3);
  Task task = patches_on(mesh, 200);
  const Task again = task;
  for (int p = 0; p < 200; ++p) {
    const std::vector<int> corners(again.constraints.patches.vertices.begin() + 3 * p,
                                   again.constraints.patches.vertices.begin() + 3 * p + 3);
    task.add_patch(corners, {1, 2, 3}, again.targets.row(p).transpose() + Vector3(0, 0, .01));
  }
  arap::SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  const arap::SolveResult result = solver.solve(task.targets, to_accuracy(1e-6));
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  Task middle = again;
  middle.targets.rowwise() += Eigen::RowVector3d(0, 0, .005);
  EXPECT_LT(largest_gap(middle, result.positions), 1e-6);
}

TEST(ManyPatches, WithAWideOneAndHardVerticesAreAllMet) {
  const MeshData mesh = bumpy_sphere(4);
  Task task = patches_on(mesh, 300);
  std::vector<int> wide;
  for (int v = 0; v < 400; ++v) wide.push_back(6 * v);
  const std::vector<double> weights(wide.size(), 1.0);
  task.add_patch(wide, weights, average(mesh.positions(), wide, weights) + Vector3(0, .02, .01));
  arap::SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  EXPECT_LT(largest_gap(task, solver.solve(task.targets, iterations(3)).positions), 1e-9);
}

TEST(ManyPatches, OfALatticeAreMet) {
  const MeshData mesh = box({30, 10, 10}, {3, 1, 1}, Faces::kQuads);
  const Task task = patches_on(mesh, 1000);
  arap::LatticeArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  EXPECT_LT(largest_gap(task, solver.solve(task.targets, iterations(3)).positions), 1e-6);
}

TEST(ManyPatches, AreRowsOfTheMatrixAndFewAreADenseSystem) {
  const MeshData mesh = bumpy_sphere(4);
  arap::SurfaceModel model;
  const arap::Options options;
  static_cast<void>(arap::prepare_surface(model, mesh.mesh(), options, {}, {}, {}));
  for (const int n : {50, 1000}) {
    const arap::PreparedConstraints prepared(model.prepared, {patches_on(mesh, n).constraints, {}}, {});
    const size_t n_dense = n > 100 ? 0 : 50;
    EXPECT_EQ(prepared.patches.size(), n_dense);
    EXPECT_EQ(prepared.system().averages().size(), n_dense);
    EXPECT_EQ(prepared.stiff_rows.rows.size(), n - static_cast<int>(n_dense));
    EXPECT_EQ(prepared.system().n_held(), n);
  }
}

}  // namespace
}  // namespace arap_test
