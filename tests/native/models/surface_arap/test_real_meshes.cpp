// SPDX-License-Identifier: GPL-3.0-or-later

// Scanned and modelled meshes from outside the repository: the directory ARAP_TEST_MESHES names.

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::EdgeWeights;
using arap::Energy;
using arap::InitialGuess;
using arap::SolveResult;
using arap::SurfaceArap;

/// `name`.off, moved nowhere, scaled to a diagonal of 1.
MeshData load(const std::string& name) {
  const MeshData mesh = load_off(*real_mesh_directory() + "/" + name + ".off");
  const double diagonal = mesh.diagonal();
  return transformed(mesh, [&](const Vector3& p) { return Vector3(p / diagonal); });
}

/// The lowest ceil(5 %) of the vertices in y pinned, the top ceil(2 %) turned by 60 degrees about z through the centre
/// of the bounding box and moved by .3 (1, 1, 1) / sqrt 3.
Task standard_task(const MeshData& mesh) {
  const Positions p = mesh.positions();
  const Vector3 centre = (p.colwise().maxCoeff() + p.colwise().minCoeff()).transpose() / 2;
  const Matrix3 turn = rotation_about(Vector3::UnitZ(), std::numbers::pi / 3);
  const Vector3 shift = .3 * Vector3(1, 1, 1).normalized();
  Task task = hold(mesh, extreme_vertices(p, 1, .05));
  for (const int v : extreme_vertices(p, 1, -.02)) task.add(v, centre + turn * (mesh.vertices[v] - centre) + shift);
  return task;
}

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
                         [](const auto& mesh) { return std::string(mesh.param); });

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

TEST_F(RealMeshes, EnergiesReachTheKnownMinima) {
  const MeshData mesh = load("armadillo_10k");
  const Task task = standard_task(mesh);
  struct Known {
    Model model;
    double minimum;
  };
  // The yardstick of spokes and rims has no 1/3.
  for (const auto& [model, minimum] : {Known{{Energy::kSpokes, EdgeWeights::kCotangent}, .0107515},
                                       Known{{Energy::kSpokesAndRims, EdgeWeights::kCotangent}, .0154888 / 3}}) {
    const Reference plain(mesh, model.energy, model.weights);
    const SolveResult result = solve_once(mesh, task, to_accuracy(1e-4, InitialGuess::kRest, 300), model.options());
    const double energy = plain.energy(result.positions);
    EXPECT_NEAR(energy, minimum, .005 * minimum) << model.name();
    EXPECT_NEAR(result.energy_after, energy, 1e-5 * energy) << model.name() << " in single precision";
    const SolveResult exact = solve_once(mesh, task, to_accuracy(1e-8, InitialGuess::kRest, 300), model.options());
    EXPECT_NEAR(exact.energy_after, plain.energy(exact.positions), 1e-9 * energy) << model.name();
  }
}

}  // namespace
}  // namespace arap_test
