// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/embedded_deformation/node_unknowns.h"

#include <gtest/gtest.h>

#include "dense/small_matrices.h"
#include "models/embedded_deformation/deformation_graph.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::GraphNodes;
using arap::NodeUnknowns;

constexpr int kNodes = 4;
constexpr double kWeight = 1.5;

/// A symmetric positive definite matrix for the rows of a state, with gaps.
Eigen::MatrixXd some_matrix() {
  const Eigen::Index n = Eigen::Index{arap::kNodeRows} * kNodes;
  const Positions noise = Random(5).noise(static_cast<int>(n), 1);
  Eigen::MatrixXd K = noise * noise.transpose() + Eigen::MatrixXd::Identity(n, n);
  K.topRightCorner(4, 4).setZero();
  K.bottomLeftCorner(4, 4).setZero();
  return K;
}

/// Nodes that have turned, and affine ones a little more.
Positions some_state(GraphNodes kind) {
  Random random(7);
  Positions state(arap::kNodeRows * kNodes, 3);
  for (int j = 0; j < kNodes; ++j) {
    arap::rows_of(state, j).topRows<3>() = random.rigid_motion(2, 0).rotation;
    arap::rows_of(state, j).row(3) = random.vector(1).transpose();
  }
  if (kind == GraphNodes::kAffine) state += random.noise(static_cast<int>(state.rows()), .2);
  return state;
}

class NodesOfEachKind : public testing::TestWithParam<GraphNodes> {
 protected:
  const Eigen::MatrixXd K = some_matrix();
  const Positions state = some_state(GetParam());
  const std::unique_ptr<NodeUnknowns> unknowns = NodeUnknowns::make(GetParam(), kWeight, K.sparseView());
  const Eigen::Index n = Eigen::Index{unknowns->per_node()} * kNodes;

  const Positions pull = Random(9).noise(static_cast<int>(state.rows()), 3);

  [[nodiscard]] Positions of_state(const Positions& x) const { return K * x - pull; }
  [[nodiscard]] Eigen::VectorXd gradient_at(const Positions& x) const { return unknowns->gradient(x, of_state(x)); }
  [[nodiscard]] double energy_at(const Positions& x) const {
    return unknowns->energy(x) + (x.transpose() * (K * x - 2 * pull)).trace();
  }
};

TEST_P(NodesOfEachKind, GradientAgreesWithDifferences) {
  constexpr double kStep = 1e-5;
  const Eigen::VectorXd gradient = gradient_at(state);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(n, k);
    const double slope =
        (energy_at(unknowns->stepped(state, step)) - energy_at(unknowns->stepped(state, -step))) / kStep / 2;
    EXPECT_NEAR(2 * gradient[k], slope, 1e-7 * gradient.norm()) << k;
  }
}

/// J^T J: by differences, and of the products of columns.
Eigen::MatrixXd square_of(GraphNodes kind, NodeUnknowns& unknowns, const Eigen::MatrixXd& K, const Positions& state) {
  constexpr double kStep = 1e-6;
  const Eigen::Index n = Eigen::Index{unknowns.per_node()} * kNodes;
  Eigen::MatrixXd changes(state.size(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(n, k);
    const Positions change = (unknowns.stepped(state, step) - unknowns.stepped(state, -step)) / (2 * kStep);
    changes.col(k) = change.reshaped<Eigen::RowMajor>();
  }
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(state.size(), state.size());
  for (Eigen::Index p = 0; p < K.rows(); ++p)
    for (Eigen::Index q = 0; q < K.cols(); ++q) spread.block<3, 3>(3 * p, 3 * q) = K(p, q) * Matrix3::Identity();
  Eigen::MatrixXd square = changes.transpose() * spread * changes;
  if (kind == GraphNodes::kRigid) return square;
  for (int j = 0; j < kNodes; ++j) {
    const Matrix3 columns = arap::rows_of(state, j).topRows<3>();
    const auto products = [&](const Matrix3& of) { return Matrix3(of * of.transpose()); };
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
        for (int k = 0; k < 9; ++k) {
          Matrix3 moved = columns;
          moved(k / 3, k % 3) += kStep;
          row[12 * j + k] = (products(moved) - products(columns))(a, b) / kStep;
        }
        square += kWeight * row * row.transpose();
      }
  }
  return square;
}

TEST_P(NodesOfEachKind, MatrixIsThatOfSecondDerivatives) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd hessian(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(n, k);
    hessian.col(k) =
        (gradient_at(unknowns->stepped(state, step)) - gradient_at(unknowns->stepped(state, -step))) / (2 * kStep);
  }
  // Turns do not commute: only the symmetric part is of the energy.
  hessian = (hessian + hessian.transpose().eval()) / 2;
  const Eigen::MatrixXd whole = unknowns->matrix(state, of_state(state), NodeUnknowns::Curvature::kWhole);
  EXPECT_LT((whole - whole.transpose()).norm(), 1e-12 * whole.norm());
  EXPECT_LT((whole - hessian).norm(), 1e-5 * hessian.norm());

  const Eigen::MatrixXd square = square_of(GetParam(), *unknowns, K, state);
  const auto [curvatures, axes] = arap::symmetric_eigen(Eigen::MatrixXd(hessian - square));
  EXPECT_LT(curvatures.minCoeff(), -.1);
  EXPECT_GT(curvatures.maxCoeff(), .1);
  const Eigen::MatrixXd bent = axes * curvatures.cwiseMax(0).asDiagonal() * axes.transpose();
  const Eigen::MatrixXd matrix = unknowns->matrix(state, of_state(state), NodeUnknowns::Curvature::kNotNegative);
  EXPECT_LT((matrix - square - bent).norm(), 1e-5 * matrix.norm());
}

TEST_P(NodesOfEachKind, RotationsCostNothing) {
  EXPECT_NEAR(unknowns->energy(some_state(GraphNodes::kRigid)), 0, 1e-20);
  if (GetParam() == GraphNodes::kAffine) {
    EXPECT_GT(unknowns->energy(state), 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Embedded, NodesOfEachKind, testing::Values(GraphNodes::kAffine, GraphNodes::kRigid));

}  // namespace
}  // namespace arap_test
