// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/cage_arap/cage_energy.h"

#include <gtest/gtest.h>

#include <numeric>

#include "arap/surface_arap.h"
#include "optimize/engine.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::CageArapOptions;
using arap::CageEnergy;
using arap::CagePoints;

/// A mesh of diagonal 1 in a cage, every vertex with a rotation of its own, and its energy over the cage's vertices.
struct Caged {
  explicit Caged(CageEnergy energy)
      : data(in_unit_size(bumpy_sphere(2))),
        mesh(data.mesh()),
        cage(arap::make_cage(mesh, 3)),
        carried(data.n_vertices()),
        points(cage, mesh.positions(), {}, {}) {
    std::iota(carried.begin(), carried.end(), 0);
    CageArapOptions options;
    options.energy = energy;
    options.rigidity_radius = 1e-6;
    assemble_cage_energy(model, cage, mesh, carried, points, options, {});
    model.solver = model.make_solver();
    model.keep_numbers();
  }

  [[nodiscard]] Positions bent() const { return cage.positions() + Random(9).noise(cage.n_vertices(), .1); }

  MeshData data;
  arap::PolygonMesh mesh;
  arap::PolygonMesh cage;
  std::vector<int> carried;
  CagePoints points;
  arap::PreparedModel model;
};

double surface_energy_at(const arap::PolygonMesh& mesh, const Positions& positions) {
  arap::Options options;
  options.rigidity_radius = 1e-6;
  return arap::SurfaceArap(mesh, options).energy(positions);
}

TEST(CageEnergy, OfTheCageIsThatOfItsSurface) {
  const Caged caged(CageEnergy::kCage);
  arap::Engine engine(caged.model);
  Positions gradient;
  const double expected = surface_energy_at(caged.cage, caged.bent());
  EXPECT_NEAR(engine.evaluate(caged.bent(), gradient), expected, 1e-9 * expected);
}

TEST(CageEnergy, OfTheMeshIsThatOfWhatTheCageCarriesAndALittleOfItsOwn) {
  const Caged caged(CageEnergy::kMesh);
  arap::Engine engine(caged.model);
  Positions gradient;
  const Positions carried = caged.points.rows(0, caged.data.n_vertices()) * caged.bent();
  const double expected = surface_energy_at(caged.mesh, carried) + 1e-3 * surface_energy_at(caged.cage, caged.bent());
  EXPECT_NEAR(engine.evaluate(caged.bent(), gradient), expected, 1e-9 * expected);
}

TEST(CageEnergy, RestsAtRestAndAfterRigidMotions) {
  for (const CageEnergy energy : {CageEnergy::kCage, CageEnergy::kMesh}) {
    const Caged caged(energy);
    arap::Engine engine(caged.model);
    Positions gradient;
    for (const RigidMotion& motion : {RigidMotion{}, Random(4).rigid_motion(3, 2)}) {
      EXPECT_LT(engine.evaluate(motion.apply(caged.cage.positions()), gradient), 1e-11);
      EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-10);
    }
  }
}

TEST(CageEnergy, GradientIsThatOfDifferences) {
  for (const CageEnergy energy : {CageEnergy::kCage, CageEnergy::kMesh}) {
    const Caged caged(energy);
    arap::Engine engine(caged.model);
    Positions gradient;
    engine.evaluate(caged.bent(), gradient);
    const auto of = [&](const Positions& at) {
      Positions unused;
      return engine.evaluate(at, unused);
    };
    EXPECT_LT(max_distance(differences(of, caged.bent(), 1e-5), gradient), 1e-7 * gradient.norm());
  }
}

}  // namespace
}  // namespace arap_test
