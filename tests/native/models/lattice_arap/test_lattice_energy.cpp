// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/lattice_energy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "constraints/prepared_model.h"
#include "optimize/engine.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::Lattice;

/// The energy alone, over control points.
struct Model {
  explicit Model(const MeshData& mesh, double cube_size, double volume_stiffness = 0)
      : lattice(mesh.mesh(), cube_size) {
    prepared.energy.volume_stiffness = volume_stiffness;
    arap::assemble_lattice_energy(prepared.energy, lattice, {}, 1, {}, [] { return nullptr; });
    prepared.rest = lattice.rest();
    prepared.part_of_vertex = lattice.part_of_control_point();
    prepared.n_parts = mesh.mesh().n_parts();
    prepared.solver = prepared.make_solver();
    prepared.keep_numbers();
  }

  double energy(const Positions& control_points) {
    Positions gradient;
    return arap::Engine(prepared).evaluate(control_points, gradient);
  }
  Positions gradient(const Positions& control_points) {
    Positions gradient;
    arap::Engine(prepared).evaluate(control_points, gradient);
    return gradient;
  }
  /// Of all pieces, as the energy weighs it.
  [[nodiscard]] double volume() const { return prepared.energy.rest_energy / 3; }

  Lattice lattice;
  arap::PreparedModel prepared;
};

Positions moved(const Positions& points, const Matrix3& map) { return points * map.transpose(); }

TEST(LatticeEnergy, IsZeroAtRestAndAfterARigidMotion) {
  for (const MeshData& mesh : {cylinder(20, 10), grid(6, Faces::kQuads), two_spheres(1)}) {
    Model model(mesh, 0.3);
    EXPECT_NEAR(model.energy(model.lattice.rest()), 0, 1e-12 * model.volume());
    const RigidMotion motion = Random(3).rigid_motion(1, 2);
    EXPECT_NEAR(model.energy(motion.apply(model.lattice.rest())), 0, 1e-12 * model.volume());
  }
}

/// E = V (|F - R|^2 + k (det F - 1)^2) for every affine map F, R its rotation.
TEST(LatticeEnergy, OfAnAffineMapIsTheVolumeTimesItsDistanceFromRotations) {
  Random random(4);
  for (const double volume_stiffness : {0.0, 2.0}) {
    Model model(cylinder(20, 10), 0.3, volume_stiffness);
    for (int k = 0; k < 10; ++k) {
      Matrix3 map = random.rigid_motion(1, 0).rotation;
      for (int i = 0; i < 3; ++i) map.col(i) += random.vector(.3);
      const double change = map.determinant() - 1;
      const double expected =
          model.volume() * ((map - best_rotation(map)).squaredNorm() + volume_stiffness * change * change);
      EXPECT_NEAR(model.energy(moved(model.lattice.rest(), map)), expected, 1e-10 * expected);
    }
  }
}

TEST(LatticeEnergy, WeighsPiecesByWhatIsInside) {
  Model model(cylinder(40, 20), 0.1);
  // Pieces with hardly anything inside count as a fiftieth of a cube.
  EXPECT_NEAR(model.volume(), 3.14159 / 4 * 2, 0.03);
}

TEST(LatticeEnergy, HasTheGradientOfCentralDifferences) {
  Random random(8);
  for (const MeshData& mesh : {cylinder(12, 6), grid(5, Faces::kTriangles), bumpy_sphere(1)})
    for (const double volume_stiffness : {0.0, 2.0}) {
      Model model(mesh, 0.35, volume_stiffness);
      const Positions& rest = model.lattice.rest();
      const Positions pose = rest + random.noise(static_cast<int>(rest.rows()), .1);
      const Positions gradient = model.gradient(pose);
      for (int k = 0; k < 5; ++k) {
        const Positions direction = random.noise(static_cast<int>(rest.rows()), 1);
        constexpr double kStep = 1e-5;
        const double difference =
            (model.energy(pose + kStep * direction) - model.energy(pose - kStep * direction)) / (2 * kStep);
        EXPECT_NEAR(gradient.cwiseProduct(direction).sum(), difference, 1e-7 * gradient.norm() * direction.norm());
      }
    }
}

}  // namespace
}  // namespace arap_test
