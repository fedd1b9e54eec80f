// SPDX-License-Identifier: GPL-3.0-or-later
#include "cell_energy.h"

#include <gtest/gtest.h>

#include <vector>

#include "meshes.h"

namespace arap_test {
namespace {

using arap::CellEnergy;

/// Any energy of the one form: three cells over five vertices, one of which is in no cell, one cell of one vertex.
CellEnergy some_energy() {
  CellEnergy energy;
  energy.K.resize(5, 5);
  for (int v = 0; v < 5; ++v) energy.K.insert(v, v) = v + 1;
  energy.K.makeCompressed();
  energy.cell_offsets = {0, 3, 6, 7};
  energy.cell_vertices = {0, 1, 2, 3, 2, 0, 1};
  energy.q = Random(51).noise(7, 1);
  energy.index_by_vertex();
  return energy;
}

TEST(CellEnergy, IncidencesByVertexAreTheSameOnes) {
  const CellEnergy energy = some_energy();
  EXPECT_EQ(energy.n_cells(), 3);
  EXPECT_EQ(energy.n_vertices(), 5);
  ASSERT_EQ(energy.vertex_offsets.size(), 6u);
  EXPECT_EQ(energy.vertex_offsets.back(), 7);
  std::vector<int> seen(7, 0);
  for (int v = 0; v < 5; ++v) {
    for (int e = energy.vertex_offsets[v]; e < energy.vertex_offsets[v + 1]; ++e) {
      const int incidence = energy.vertex_incidences[e];
      const int cell = energy.vertex_cells[e];
      ++seen[incidence];
      EXPECT_EQ(energy.cell_vertices[incidence], v);
      EXPECT_TRUE(energy.cell_offsets[cell] <= incidence && incidence < energy.cell_offsets[cell + 1]);
    }
  }
  EXPECT_EQ(seen, std::vector<int>(7, 1));
}

TEST(CellEnergy, CovarianceIsTheSumOverTheCell) {
  const CellEnergy energy = some_energy();
  const Positions p = Random(52).noise(5, 1);
  for (int c = 0; c < 3; ++c) {
    Matrix3 expected = Matrix3::Zero();
    for (int e = energy.cell_offsets[c]; e < energy.cell_offsets[c + 1]; ++e)
      expected += p.row(energy.cell_vertices[e]).transpose() * energy.q.row(e);
    EXPECT_LT((energy.covariance(c, p) - expected).norm(), 1e-14);
  }
}

TEST(CellEnergy, RightHandSideTurnsAndAddsTheRestVectors) {
  const CellEnergy energy = some_energy();
  Random random(53);
  std::vector<Matrix3> rotations;
  for (int c = 0; c < 3; ++c) rotations.push_back(random.rigid_motion(2, 0).rotation);
  Positions expected = Positions::Zero(5, 3);
  for (int c = 0; c < 3; ++c)
    for (int e = energy.cell_offsets[c]; e < energy.cell_offsets[c + 1]; ++e)
      expected.row(energy.cell_vertices[e]) += (rotations[c] * energy.q.row(e).transpose()).transpose();
  for (const int threads : {1, 2}) {
    Positions b;
    energy.right_hand_side(rotations, b, threads);
    ASSERT_EQ(b.rows(), 5);
    EXPECT_LT((b - expected).norm(), 1e-14);
    EXPECT_EQ(b.row(4).norm(), 0) << "a vertex in no cell";
  }
}

TEST(CellEnergy, FittedRotationsMaximizeTheirProducts) {
  const CellEnergy energy = some_energy();
  Random random(54);
  const Positions p = random.noise(5, 1);
  for (const int threads : {1, 2}) {
    std::vector<Matrix3> rotations(3, Matrix3::Identity());
    energy.fit_rotations(p, rotations, threads);
    for (int c = 0; c < 3; ++c) {
      const Matrix3 Q = energy.covariance(c, p);
      EXPECT_LT((rotations[c].transpose() * rotations[c] - Matrix3::Identity()).norm(), 1e-13);
      EXPECT_NEAR(rotations[c].determinant(), 1, 1e-13);
      for (int trial = 0; trial < 50; ++trial) {
        const Matrix3 other = random.rigid_motion(random.uniform(0, 3), 0).rotation * rotations[c];
        EXPECT_LE(other.cwiseProduct(Q).sum(), rotations[c].cwiseProduct(Q).sum() + 1e-12);
      }
    }
  }
}

TEST(CellEnergy, ManyCellsGiveTheSameWithAnyNumberOfThreads) {
  CellEnergy energy;
  const int n = 5000;
  energy.K.resize(n, n);
  energy.K.setIdentity();
  for (int c = 0; c < n; ++c) {
    energy.cell_offsets.push_back(3 * c);
    for (int k = 0; k < 3; ++k) energy.cell_vertices.push_back((c + 17 * k) % n);
  }
  energy.cell_offsets.push_back(3 * n);
  energy.q = Random(55).noise(3 * n, 1);
  energy.index_by_vertex();
  const Positions p = Random(56).noise(n, 1);
  std::vector<Matrix3> one(static_cast<size_t>(n), Matrix3::Identity());
  std::vector<Matrix3> two = one;
  energy.fit_rotations(p, one, 1);
  energy.fit_rotations(p, two, 2);
  EXPECT_EQ(one, two);
  Positions b_one;
  Positions b_two;
  energy.right_hand_side(one, b_one, 1);
  energy.right_hand_side(one, b_two, 2);
  EXPECT_EQ(b_one, b_two);
}

}  // namespace
}  // namespace arap_test
