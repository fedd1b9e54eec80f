// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/lattice_energy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "constraints/prepared_model.h"
#include "energy/cell_passes.h"
#include "kernels/isa.h"
#include "optimize/engine.h"
#include "support/helpers.h"
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

/// The same energy with all q_cj in lists, as the formulas have them.
arap::CellEnergy listed(const Model& model, const std::vector<double>& weights) {
  constexpr double kSmooth[] = {1.0 / 6, 2.0 / 3, 1.0 / 6};
  constexpr double kMean[] = {.125, .75, .125};
  constexpr double kSlope[] = {-.5, 0, .5};
  const int n = model.lattice.n_control_points();
  std::vector<std::vector<CellEntry>> cells(n);
  for (int c = 0; c < n; ++c) cells[c].push_back({c, Vector3::Zero()});
  const auto at = [](int k) { return std::array<int, 3>{k / 9, k / 3 % 3, k % 3}; };
  for (int piece = 0; piece < model.lattice.n_pieces(); ++piece)
    for (int k = 0; k < arap::kControlPoints; ++k)
      for (int j = 0; j < arap::kControlPoints; ++j) {
        const auto [cx, cy, cz] = at(k);
        const auto [x, y, z] = at(j);
        const Vector3 gradient(kSlope[x] * kMean[y] * kMean[z], kMean[x] * kSlope[y] * kMean[z],
                               kMean[x] * kMean[y] * kSlope[z]);
        cells[model.lattice.control_points(piece)[k]].push_back(
            {model.lattice.control_points(piece)[j],
             kSmooth[cx] * kSmooth[cy] * kSmooth[cz] * weights[piece] * gradient});
      }
  const arap::CellEnergy& energy = model.prepared.energy;
  arap::CellEnergy result;
  result.K = energy.K;
  result.cells = make_cells(n, cells);
  result.rest_energy = energy.rest_energy;
  result.volume_stiffness = energy.volume_stiffness;
  return result;
}

/// In both precisions, on every instruction set of the machine, by one thread and by three.
TEST(LatticeEnergy, OfCubesIsThatOfTheListOfAllRestVectors) {
  Random random(12);
  for (const double volume_stiffness : {0.0, 2.0}) {
    const Model model(bumpy_sphere(2), .15, volume_stiffness);
    const arap::CellEnergy& energy = model.prepared.energy;
    // What an iteration reads: the control points of each piece, and nothing of each cell.
    EXPECT_EQ(energy.cells.size(), 0);
    EXPECT_EQ(static_cast<int>(energy.cubes.slots().size()), arap::kControlPoints * model.lattice.n_pieces());
    const arap::CellEnergy reference = listed(model, energy.cubes.weights());
    const Positions& rest = model.lattice.rest();
    const Positions pose = random.rigid_motion(1, 1).apply(rest) +
                           random.noise(static_cast<int>(rest.rows()), .3 * model.lattice.cube_size());
    for (const auto precision : {arap::Precision::kSingle, arap::Precision::kDouble})
      for (const arap::Isa isa : arap::available_isas())
        for (const int threads : {1, 3}) {
          const double epsilon = precision == arap::Precision::kSingle ? 2e-6 : 1e-10;
          const auto tested = make_cell_passes(energy, energy.cells, rest, precision, arap::Workers(threads), isa);
          const auto expected =
              make_cell_passes(reference, reference.cells, rest, arap::Precision::kDouble, arap::Workers(1));
          EXPECT_NEAR(tested->rest_energy(), energy.rest_energy, epsilon * energy.rest_energy);
          tested->set_positions(pose);
          expected->set_positions(pose);
          const double alignment = expected->fit_rotations();
          EXPECT_NEAR(tested->fit_rotations(), alignment, epsilon * std::abs(alignment));
          EXPECT_NEAR(tested->alignment(), alignment, epsilon * std::abs(alignment));
          EXPECT_NEAR(tested->alignment_after({0}), alignment, epsilon * std::abs(alignment));
          Positions residual;
          Positions of_list;
          const double of_positions = expected->find_residual(of_list);
          EXPECT_NEAR(tested->find_residual(residual), of_positions, epsilon * of_positions);
          EXPECT_LT((residual - of_list).rowwise().norm().maxCoeff(),
                    10 * epsilon * of_list.rowwise().norm().maxCoeff());
        }
  }
}

/// The places where a solver wants control points are those of their cells, too.
TEST(LatticeEnergy, IsTheSameInEveryOrder) {
  Random random(13);
  const Lattice lattice(cylinder(12, 6).mesh(), .3);
  const int n = lattice.n_control_points();
  std::vector<int> order(n);  // of the new ones
  for (int c = 0; c < n; ++c) order[c] = n - 1 - c;
  const Positions pose = lattice.rest() + random.noise(n, .1);
  std::vector<double> found;
  for (const bool is_turned : {false, true}) {
    arap::PreparedModel prepared;
    prepared.energy.volume_stiffness = 1;
    arap::assemble_lattice_energy(prepared.energy, lattice, {}, 1, {}, [&] { return is_turned ? &order : nullptr; });
    const auto numbered = [&](const Positions& points) {
      return is_turned ? Positions(points.colwise().reverse()) : points;
    };
    const auto passes = make_cell_passes(prepared.energy, prepared.energy.cells, numbered(lattice.rest()),
                                         arap::Precision::kDouble, arap::Workers(1));
    passes->set_positions(numbered(pose));
    found.push_back(passes->fit_rotations());
    Positions residual;
    found.back() -= passes->find_residual(residual);
  }
  EXPECT_NEAR(found[0], found[1], 1e-12 * std::abs(found[0]));
}

}  // namespace
}  // namespace arap_test
