// SPDX-License-Identifier: GPL-3.0-or-later

// Scanned and modelled meshes from outside the repository: the directory ARAP_TEST_MESHES names.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::EdgeWeights;
using arap::Energy;
using arap::InitialGuess;
using arap::SolveResult;
using arap::StopReason;
using arap::SurfaceArap;

/// `name`.off, moved nowhere, scaled to a diagonal of 1.
MeshData load(const std::string& name) {
  const MeshData mesh = load_off(*real_mesh_directory() + "/" + name + ".off");
  const double diagonal = mesh.diagonal();
  return transformed(mesh, [&](const Vector3& p) { return Vector3(p / diagonal); });
}

/// The lowest ceil(5 %) of the vertices in y pinned, the top ceil(2 %) turned by 60 degrees about z through the centre
/// of the bounding box and moved by .3 (1, 1, 1) / sqrt 3.
Task standard_task(const MeshData& mesh, double share = 1) {
  const Positions p = mesh.positions();
  const Vector3 centre = (p.colwise().maxCoeff() + p.colwise().minCoeff()).transpose() / 2;
  const Matrix3 turn = rotation_about(Vector3::UnitZ(), share * std::numbers::pi / 3);
  const Vector3 shift = share * .3 * Vector3(1, 1, 1).normalized();
  Task task = hold(mesh, extreme_vertices(p, 1, .05));
  for (const int v : extreme_vertices(p, 1, -.02)) task.add(v, centre + turn * (mesh.vertices[v] - centre) + shift);
  return task;
}

std::string file_name(const testing::TestParamInfo<const char*>& name) { return name.param; }

class RealMeshes : public testing::Test {
 protected:
  void SetUp() override {
    if (!real_mesh_directory())
      GTEST_SKIP() << "not run: set ARAP_TEST_MESHES to the directory of the real meshes (armadillo_10k.off, ...)";
  }
};

class EachRealMesh : public RealMeshes, public testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(All, EachRealMesh,
                         testing::Values("armadillo_250", "armadillo_500", "armadillo_1k", "armadillo_2k",
                                         "armadillo_5k", "armadillo_10k", "armadillo_43k", "cactus_small",
                                         "cactus_highres", "dino"),
                         file_name);

TEST_P(EachRealMesh, RestInRestOut) {
  const MeshData mesh = load(GetParam());
  const Task task = standard_task(mesh, 0);
  for (const Model& model : {all_models()[0], all_models()[2]}) {
    const SolveResult result = solve_once(mesh, task, iterations(10), model.options());
    EXPECT_LT(max_distance(result.positions, mesh.positions()), 1e-6) << model.name();
  }
}

TEST_P(EachRealMesh, OneRigidMotionOfAllHandlesIsThatMotionFromTheirRotations) {
  const MeshData mesh = load(GetParam());
  const RigidMotion motion = Random(111).rigid_motion(2.5, 1);
  const Task task = rigid_task(mesh, standard_task(mesh).constraints, motion);
  const SolveResult result = solve_once(mesh, task, iterations(1, InitialGuess::kHandleRotations));
  EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-6);
}

TEST_P(EachRealMesh, EnergyNeverRises) {
  const MeshData mesh = load(GetParam());
  const Task task = standard_task(mesh);
  const bool is_large = mesh.n_vertices() > 20000;
  for (const Model& model :
       {all_models()[0], all_models()[2], Model{Energy::kRotationNodes, EdgeWeights::kCotangent}}) {
    SurfaceArap solver(mesh.mesh(), model.options());
    solver.set_constraints(task.constraints);
    expect_energy_never_rises(solver, mesh, task.targets, is_large ? 8 : 30, model.name());
  }
}

TEST_P(EachRealMesh, EnergyIsTheDoubleSum) {
  const MeshData mesh = load(GetParam());
  const Positions p = mesh.positions() + Random(112).noise(mesh.n_vertices(), .01);
  for (const Model& model : {all_models()[0], all_models()[2]}) {
    const double expected = Reference(mesh, model.energy, model.weights).energy(p);
    EXPECT_NEAR(SurfaceArap(mesh.mesh(), model.options()).energy(p), expected, 1e-9 * expected) << model.name();
  }
}

TEST_F(RealMeshes, SpokesReachTheKnownMinimum) {
  const MeshData mesh = load("armadillo_10k");
  const Task task = standard_task(mesh);
  const Model model{Energy::kSpokes, EdgeWeights::kCotangent};
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-4, InitialGuess::kRest, 300), model.options());
  const double Ec = Reference(mesh, model.energy, model.weights).energy(result.positions);
  EXPECT_NEAR(Ec, .0107515, .005 * .0107515);
  EXPECT_NEAR(result.energy_after, Ec, 1e-5 * Ec) << "in single precision";
  const SolveResult exact = solve_once(mesh, task, to_accuracy(1e-8, InitialGuess::kRest, 300), model.options());
  EXPECT_NEAR(exact.energy_after, Reference(mesh, model.energy, model.weights).energy(exact.positions), 1e-9 * Ec);
}

TEST_F(RealMeshes, SpokesAndRimsReachTheKnownMinimum) {
  const MeshData mesh = load("armadillo_10k");
  const Task task = standard_task(mesh);
  const Model model{Energy::kSpokesAndRims, EdgeWeights::kCotangent};
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-4, InitialGuess::kRest, 300), model.options());
  // The yardstick has no 1/3.
  const double Er = 3 * Reference(mesh, model.energy, model.weights).energy(result.positions);
  EXPECT_NEAR(Er, .0154888, .005 * .0154888);
  EXPECT_NEAR(3 * result.energy_after, Er, 1e-5 * Er);
}

class SmallRealMesh : public RealMeshes, public testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(Small, SmallRealMesh,
                         testing::Values("armadillo_250", "armadillo_500", "armadillo_1k", "armadillo_2k",
                                         "cactus_small"),
                         file_name);

TEST_P(SmallRealMesh, ThereAndBackEndsAtRest) {
  const MeshData mesh = load(GetParam());
  for (const Model& model : {all_models()[0], all_models()[2]}) {
    SurfaceArap solver(mesh.mesh(), model.options());
    const Task there = standard_task(mesh);
    solver.set_constraints(there.constraints);
    const SolveResult posed = solver.solve(there.targets, to_accuracy(1e-9));
    EXPECT_EQ(posed.stop_reason, StopReason::kConverged) << model.name();
    EXPECT_GT(max_distance(posed.positions, mesh.positions()), .2) << model.name();
    const SolveResult back = solver.solve(standard_task(mesh, 0).targets, to_accuracy(1e-9));
    EXPECT_EQ(back.stop_reason, StopReason::kConverged) << model.name();
    EXPECT_LT(max_distance(back.positions, mesh.positions()), 1e-4) << model.name();
    RecordProperty(model.name(), posed.iterations + back.iterations);
  }
}

TEST_F(RealMeshes, RigidRegionOfARealMeshMovesAsOne) {
  const MeshData mesh = load("armadillo_5k");
  const Task task = standard_task(mesh);
  std::vector<int> regions;
  std::vector<int> inside;
  const Positions p = mesh.positions();
  const double low = p.col(1).minCoeff() + .4 * (p.col(1).maxCoeff() - p.col(1).minCoeff());
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const bool is_inside = p(v, 1) > low && p(v, 1) < low + .15;
    regions.push_back(is_inside ? 0 : -1);
    if (is_inside) inside.push_back(v);
  }
  ASSERT_GT(inside.size(), 100u);
  SurfaceArap solver(mesh.mesh(), {}, with_regions(regions));
  solver.set_constraints(task.constraints);
  double energy = solver.solve(task.targets, iterations(1)).energy_after;
  for (int k = 0; k < 30; ++k) {
    const SolveResult result = solver.solve(task.targets, iterations(1));
    EXPECT_LT(off_rigid(p, result.positions, inside), 1e-6);
    EXPECT_LE(result.energy_after, energy * (1 + 1e-12));
    energy = result.energy_after;
  }
}

}  // namespace
}  // namespace arap_test
