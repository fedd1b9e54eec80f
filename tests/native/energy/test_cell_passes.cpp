// SPDX-License-Identifier: GPL-3.0-or-later
// The passes of an iteration over energies of the one form, whatever their cells, against literal sums: in both
// precisions, on every instruction set of the machine.
#include "energy/cell_passes.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "support/helpers.h"
#include "support/tet_arap.h"

namespace arap_test {
namespace {

using arap::CellEnergy;
using arap::CellPasses;
using arap::Isa;
using arap::Precision;
using arap::Rotations;

/// Cells of the given vertices with random q_cj that sum to 0, and springs between random vertices, one in eight of
/// them pushing.
CellEnergy some_energy(int n_vertices, const std::vector<std::vector<int>>& cells, Random& random) {
  CellEnergy energy;
  std::vector<Eigen::Triplet<double>> entries;
  const auto vertex = [&] { return std::min(n_vertices - 1, static_cast<int>(random.uniform(0, n_vertices))); };
  for (int s = 0; s < 4 * n_vertices; ++s) {
    const int a = vertex();
    const int b = vertex();
    const double w = s % 8 == 0 ? -.1 : random.uniform(.1, 2);
    if (a == b) continue;
    entries.insert(entries.end(), {{a, a, w}, {b, b, w}, {a, b, -w}, {b, a, -w}});
  }
  energy.K.resize(n_vertices, n_vertices);
  energy.K.setFromTriplets(entries.begin(), entries.end());
  std::vector<std::vector<CellEntry>> of_cells(cells.size());
  for (size_t c = 0; c < cells.size(); ++c) {
    if (cells[c].empty()) continue;
    Vector3 sum = Vector3::Zero();
    for (const int v : cells[c]) {
      of_cells[c].push_back({v, random.vector(1)});
      sum += of_cells[c].back().q;
    }
    for (CellEntry& entry : of_cells[c]) entry.q -= sum / static_cast<double>(cells[c].size());
  }
  energy.cells = make_cells(n_vertices, of_cells);
  return energy;
}

/// Cells of all kinds: large and small, of one vertex, of none, overlapping, fewer and more than vertices.
std::vector<std::vector<int>> some_cells(int n_vertices, int n_cells, Random& random) {
  std::vector<std::vector<int>> cells(static_cast<size_t>(n_cells));
  for (size_t c = 0; c < cells.size(); ++c) {
    const int size = c % 7 == 3 ? 0 : c % 7 == 5 ? 1 : 2 + static_cast<int>(random.uniform(0, 12));
    for (int k = 0; k < size; ++k)
      cells[c].push_back((static_cast<int>(random.uniform(0, n_vertices)) + 31 * k) % n_vertices);
  }
  return cells;
}

Matrix3 covariance(const CellEnergy& energy, int c, const Positions& p) {
  Matrix3 Q = Matrix3::Zero();
  for (const auto& [v, q] : entries_of(energy.cells, c)) Q += p.row(v).transpose() * q.transpose();
  return Q;
}

/// The largest <R, Q> of any rotation.
double best_alignment(const Matrix3& Q) { return best_rotation(Q).cwiseProduct(Q).sum(); }

class CellPassesOf : public testing::TestWithParam<std::tuple<Precision, Isa, int>> {
 protected:
  std::unique_ptr<CellPasses> passes(const CellEnergy& energy, const Positions& rest) const {
    return make_cell_passes(energy, energy.cells, rest, std::get<Precision>(GetParam()),
                            arap::Workers(std::get<int>(GetParam())), std::get<Isa>(GetParam()));
  }
  [[nodiscard]] double epsilon() const { return std::get<Precision>(GetParam()) == Precision::kSingle ? 1e-6 : 1e-14; }
};

TEST_P(CellPassesOf, FittedRotationsAreTheBestOnesFromAnyStart) {
  Random random(54);
  for (const int n : {3, 20, 700}) {
    const CellEnergy energy = some_energy(n, some_cells(n, n + 13, random), random);
    const Positions p = random.noise(n, 1);
    const auto tested = passes(energy, random.noise(n, 1));
    tested->set_positions(p);
    for (const double angle_rad : {0.0, .3, 1.0, 2.0, 3.1}) {
      Rotations rotations;
      for (int c = 0; c < energy.n_cells(); ++c) rotations.emplace_back(random.rigid_motion(angle_rad, 0).rotation);
      tested->set_rotations(rotations);
      const double alignment = tested->fit_rotations();
      tested->read_rotations(rotations);
      double sum = 0;
      for (int c = 0; c < energy.n_cells(); ++c) {
        const Matrix3 Q = covariance(energy, c, p);
        const Matrix3 R = rotations[c].toRotationMatrix();
        EXPECT_NEAR(rotations[c].norm(), 1, epsilon());
        EXPECT_GE(R.cwiseProduct(Q).sum(), best_alignment(Q) - 20 * epsilon() * Q.norm()) << "cell " << c;
        sum += R.cwiseProduct(Q).sum();
      }
      EXPECT_NEAR(alignment, sum, epsilon() * n);
      EXPECT_NEAR(tested->alignment(), sum, epsilon() * n);
    }
  }
}

TEST_P(CellPassesOf, TheAlignmentFollowsSomeCellsAndVertices) {
  Random random(58);
  for (const int n : {20, 3000}) {
    const CellEnergy energy = some_energy(n, some_cells(n, n, random), random);
    Positions p = random.noise(n, 1);
    const auto tested = passes(energy, p);
    tested->set_positions(p);
    static_cast<void>(tested->fit_rotations());
    // Inside of the range of fixed point, and then beyond it.
    for (const double size : {.5, 30.0}) {
      const std::vector<int> vertices{3, n - 2};
      for (const int v : vertices) p.row(v) = random.noise(1, size);
      tested->move_vertices(vertices, p);
      const Eigen::Quaterniond rotation(random.rigid_motion(1, 0).rotation);
      tested->set_rotation(n / 2, rotation);
      EXPECT_LT((tested->rotation(n / 2).coeffs() - rotation.coeffs()).norm(), epsilon());
      std::vector<int> changed{n / 2};
      for (const int v : vertices) energy.cells.for_each_cell(v, [&](int c, const Vector3&) { changed.push_back(c); });
      const double followed = tested->alignment_after(changed);
      Rotations rotations;
      tested->read_rotations(rotations);
      double sum = 0;
      for (int c = 0; c < energy.n_cells(); ++c)
        sum += rotations[c].toRotationMatrix().cwiseProduct(covariance(energy, c, p)).sum();
      EXPECT_NEAR(followed, sum, 10 * size * epsilon() * n);
    }
  }
}

// At the ends of the range of fixed point, and beyond.
TEST_P(CellPassesOf, CoordinatesMayBeOfAnySize) {
  Random random(57);
  const int n = 40;
  const CellEnergy energy = some_energy(n, some_cells(n, n, random), random);
  const auto tested = passes(energy, random.noise(n, 1));
  Rotations rotations(static_cast<size_t>(energy.n_cells()), Eigen::Quaterniond::Identity());
  for (const double size : {1.0, 2.0, 0.999999999, 2.000000001, 8.0, 1e6, 1.0}) {
    Positions p = random.noise(n, 0.5 * size);
    for (int v = 0; v < n / 2; ++v) p.row(v).setConstant(v % 2 == 0 ? size : -size);
    Positions expected = -(energy.K * p);
    for (int v = 0; v < n; ++v)
      energy.cells.for_each_cell(v, [&](int, const Vector3& q) { expected.row(v) += q.transpose(); });
    tested->set_positions(p);
    tested->set_rotations(rotations);
    Positions residual;
    static_cast<void>(tested->find_residual(residual));
    EXPECT_LT((residual - expected).cwiseAbs().maxCoeff(), 100 * epsilon() * size) << size;
  }
}

TEST_P(CellPassesOf, ResidualIsTheLiteralSum) {
  Random random(53);
  for (const int n : {3, 17, 700}) {
    const CellEnergy energy = some_energy(n, some_cells(n, n + 3, random), random);
    const Positions p = random.noise(n, 1);
    Rotations rotations;
    for (int c = 0; c < energy.n_cells(); ++c) rotations.emplace_back(random.rigid_motion(2, 0).rotation);
    const Positions Kp = energy.K * p;
    Positions expected = -Kp;
    for (int v = 0; v < n; ++v)
      energy.cells.for_each_cell(v,
                                 [&](int c, const Vector3& q) { expected.row(v) += (rotations[c] * q).transpose(); });
    const auto tested = passes(energy, p);
    tested->set_positions(p);
    tested->set_rotations(rotations);
    Positions residual;
    const double quadratic = tested->find_residual(residual);
    ASSERT_EQ(residual.rows(), n);
    EXPECT_LT((residual - expected).cwiseAbs().maxCoeff(), 100 * epsilon());
    EXPECT_NEAR(quadratic, 0.5 * p.cwiseProduct(Kp).sum(), epsilon() * n);
  }
}

TEST_P(CellPassesOf, VolumesAddTheirTermAndStresses) {
  Random random(61);
  constexpr double kStiffness = 1.5;
  for (const int n_cubes : {1, 4}) {
    const TetMesh mesh = tet_blocks(n_cubes, n_cubes, n_cubes);
    arap::PreparedModel model;
    CellEnergy& energy = assemble(model, mesh).energy;
    energy.volume_stiffness = kStiffness;
    const Positions& rest = mesh.positions();
    const auto n = static_cast<int>(rest.rows());
    const Positions p = rest * (Matrix3::Identity() + random.noise(3, .2)) + random.noise(n, .01);
    const auto tested = passes(energy, rest);
    Positions residual;
    EXPECT_NEAR(tested->rest_energy() + tested->find_residual(residual) - tested->fit_rotations(), 0, 1e-9 + epsilon())
        << "at rest";
    tested->set_positions(p);
    const double fitted = tested->fit_rotations();
    static_cast<void>(tested->find_residual(residual));
    Rotations rotations;
    tested->read_rotations(rotations);
    double sum = 0;
    double size = 0;
    Positions of_rotations = -(energy.K * p);
    Positions expected = of_rotations;
    for (int c = 0; c < energy.n_cells(); ++c) {
      const double volume = tet_volume(mesh, c);
      const Matrix3 F = covariance(energy, c, p) / (2 * volume);
      const double change = F.determinant() - 1;
      const Matrix3 cofactors = F.determinant() * F.inverse().transpose();
      const Matrix3 R = rotations[c].toRotationMatrix();
      sum += R.cwiseProduct(2 * volume * F).sum() - kStiffness * volume * change * change;
      size += volume * (1 + F.squaredNorm() * cofactors.squaredNorm());
      for (const auto& [v, q] : entries_of(energy.cells, c)) {
        of_rotations.row(v) += (R * q).transpose();
        expected.row(v) += ((R - kStiffness * change * cofactors) * q).transpose();
      }
    }
    EXPECT_NEAR(fitted, sum, 10 * epsilon() * size);
    EXPECT_NEAR(tested->alignment(), sum, 10 * epsilon() * size);
    EXPECT_LT((residual - expected).cwiseAbs().maxCoeff(), 1000 * epsilon() * expected.cwiseAbs().maxCoeff());
    tested->set_rotations(rotations);
    static_cast<void>(tested->find_residual(residual));
    EXPECT_LT((residual - of_rotations).cwiseAbs().maxCoeff(), 100 * epsilon()) << "no stresses before they are found";
  }
}

TEST_P(CellPassesOf, FarFromTheOriginNothingIsLost) {
  Random random(57);
  const int n = 60;
  const CellEnergy energy = some_energy(n, some_cells(n, n, random), random);
  const Positions p = random.noise(n, 1);
  const auto near = passes(energy, p);
  const Positions moved = p.rowwise() + Eigen::RowVector3d(1000, -1000, 500);
  const auto far = passes(energy, moved);
  near->set_positions(p);
  far->set_positions(moved);
  EXPECT_NEAR(near->fit_rotations(), far->fit_rotations(), (epsilon() + 1e-12) * n);
  Positions of_near;
  Positions of_far;
  near->find_residual(of_near);
  far->find_residual(of_far);
  EXPECT_LT((of_near - of_far).cwiseAbs().maxCoeff(), 100 * epsilon() + 1e-11);
}

TEST_P(CellPassesOf, RestEnergyMakesTheEnergyAtRestVanish) {
  Random random(58);
  const int n = 300;
  const CellEnergy energy = some_energy(n, some_cells(n, n, random), random);
  const Positions rest = random.noise(n, 1);
  const auto tested = passes(energy, rest);
  tested->set_positions(rest);
  tested->set_rotations(Rotations(static_cast<size_t>(n), Eigen::Quaterniond::Identity()));
  Positions residual;
  EXPECT_NEAR(tested->rest_energy() + tested->find_residual(residual) - tested->alignment(), 0, 1e-11);
}

std::string pass_name(const testing::TestParamInfo<std::tuple<Precision, Isa, int>>& info) {
  return std::string(std::get<0>(info.param) == Precision::kSingle ? "single_" : "double_") +
         std::string(name(std::get<1>(info.param))) + "_threads_" + std::to_string(std::get<2>(info.param));
}

INSTANTIATE_TEST_SUITE_P(AllPaths, CellPassesOf,
                         testing::Combine(testing::Values(Precision::kSingle, Precision::kDouble),
                                          testing::ValuesIn(arap::available_isas()), testing::Values(1, 2)),
                         pass_name);

TEST(CellPasses, ManyThreadsGiveTheSameBits) {
  Random random(55);
  const int n = 5000;
  const CellEnergy energy = some_energy(n, some_cells(n, n, random), random);
  const Positions p = random.noise(n, 1);
  for (const Precision precision : {Precision::kSingle, Precision::kDouble}) {
    Positions residual[2];   // NOLINT
    double sums[2];          // NOLINT
    Rotations rotations[2];  // NOLINT
    for (const int k : {0, 1}) {
      const auto tested = make_cell_passes(energy, energy.cells, p, precision, arap::Workers(k + 1));
      tested->set_positions(p);
      sums[k] = tested->fit_rotations() + tested->find_residual(residual[k]);
      tested->read_rotations(rotations[k]);
    }
    EXPECT_EQ(sums[0], sums[1]);
    EXPECT_EQ(residual[0], residual[1]);
    for (size_t c = 0; c < rotations[0].size(); ++c) EXPECT_EQ(rotations[0][c].coeffs(), rotations[1][c].coeffs());
  }
}

/// A chain of 400 vertices at unit distances with these springs.
CellEnergy chain(const std::function<double(int)>& spring) {
  CellEnergy energy;
  std::vector<Eigen::Triplet<double>> entries;
  for (int v = 0; v + 1 < 400; ++v) {
    const double w = spring(v);
    entries.insert(entries.end(), {{v, v, w}, {v + 1, v + 1, w}, {v, v + 1, -w}, {v + 1, v, -w}});
  }
  energy.K.resize(400, 400);
  energy.K.setFromTriplets(entries.begin(), entries.end());
  return energy;
}

TEST(CellPasses, SinglePrecisionIsForNumbersOfItsRangeWithoutLargeContrasts) {
  Positions rest = Positions::Zero(400, 3);
  for (int v = 0; v < 400; ++v) rest(v, 0) = v / 400.0;
  const auto fits = [&](const std::function<double(int)>& spring) {
    return fits_single_precision(chain(spring), rest);
  };
  EXPECT_TRUE(fits([](int) { return 1.0; }));
  EXPECT_FALSE(fits([](int) { return 1e20; }));
  EXPECT_FALSE(fits([](int) { return 1e-20; }));
  EXPECT_TRUE(fits([](int v) { return v == 100 ? 0 : 1.0; })) << "weights that cancel";
  EXPECT_TRUE(fits([](int v) { return v < 50 ? 30.0 : 1.0; }));
  EXPECT_FALSE(fits([](int v) { return v < 50 ? 1000.0 : 1.0; })) << "a stiff island";
  EXPECT_FALSE(fits([](int v) { return v < 50 ? .001 : 1.0; })) << "a soft one";
  rest(200, 0) = rest(199, 0) + 1e-7;
  EXPECT_TRUE(fits([](int v) { return v == 199 ? 1e4 : 1.0; })) << "a sliver: stiff, but short";
  rest(399, 1) = 9;
  EXPECT_FALSE(fits([](int) { return 1.0; })) << "far beside the others";
}

TEST_P(CellPassesOf, ManyFitsOfRankOneKeepTheirLength) {
  Random random(60);
  std::vector<std::vector<int>> cells;
  for (int c = 0; c < 40; ++c) cells.push_back({c % 20, (c + 1) % 20});
  const CellEnergy energy = some_energy(20, cells, random);
  const Positions p = random.noise(20, 1);
  const auto tested = passes(energy, p);
  tested->set_positions(p);
  double expected = 0;
  for (int c = 0; c < energy.n_cells(); ++c) expected += best_alignment(covariance(energy, c, p));
  for (int k = 0; k < 200; ++k) ASSERT_NEAR(tested->fit_rotations(), expected, 20 * epsilon() * 20) << "fit " << k;
}

}  // namespace
}  // namespace arap_test
