// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/rotation.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::nearest_rotation;
using arap::nearest_rotation_with_axis;

double product(const Matrix3& R, const Matrix3& S) { return R.cwiseProduct(S).sum(); }

void expect_rotation(const Matrix3& R, const std::string& what) {
  EXPECT_LT((R.transpose() * R - Matrix3::Identity()).norm(), 1e-12) << what;
  EXPECT_NEAR(R.determinant(), 1, 1e-12) << what;
}

Matrix3 random_matrix(Random& random) {
  Matrix3 S;
  for (int c = 0; c < 3; ++c) S.col(c) = random.vector(1);
  return S;
}

/// Matrices with singular values of every kind, between random rotations.
std::vector<std::pair<std::string, Matrix3>> matrices() {
  const std::vector<std::pair<std::string, Vector3>> values = {{"well apart", {3, 2, 1}},
                                                               {"equal", {1, 1, 1}},
                                                               {"two equal", {2, 1, 1}},
                                                               {"two great equal", {2, 2, 1}},
                                                               {"reflection", {3, 2, -1}},
                                                               {"reflection, two equal", {2, 1, -1}},
                                                               {"rank 2", {2, 1, 0}},
                                                               {"rank 1", {2, 0, 0}},
                                                               {"nearly rank 2", {2, 1, 1e-12}},
                                                               {"nearly rank 2, reflection", {2, 1, -1e-12}},
                                                               {"nearly rank 1", {1, 1e-9, 1e-10}},
                                                               {"nearly equal", {1, 1 - 1e-9, 1 - 2e-9}},
                                                               {"nearly equal reflection", {1, .3, -.3 + 1e-10}}};
  std::vector<std::pair<std::string, Matrix3>> result;
  Random random(7);
  for (const auto& [name, sigma] : values) {
    for (int trial = 0; trial < 5; ++trial) {
      const Matrix3 U = random.rigid_motion(random.uniform(0, 3.1), 0).rotation;
      const Matrix3 V = random.rigid_motion(random.uniform(0, 3.1), 0).rotation;
      result.emplace_back(name, U * sigma.asDiagonal() * V.transpose());
    }
    result.emplace_back(name + ", along the axes", Matrix3(sigma.asDiagonal()));
  }
  for (int trial = 0; trial < 200; ++trial) result.emplace_back("random", random_matrix(random));
  return result;
}

TEST(NearestRotation, IsARotationAndMaximizesTheProduct) {
  for (const auto& [name, S] : matrices()) {
    const Matrix3 R = nearest_rotation(S, Matrix3::Identity());
    expect_rotation(R, name);
    EXPECT_NEAR(product(R, S), product(best_rotation(S), S), 1e-12 * S.norm()) << name;
  }
}

TEST(NearestRotation, DoesNotDependOnTheScale) {
  Random random(9);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix3 S = random_matrix(random);
    const Matrix3 R = nearest_rotation(S, Matrix3::Identity());
    for (const double scale : {1e-30, 1e-12, 1e12, 1e30})
      EXPECT_LT((nearest_rotation(scale * S, Matrix3::Identity()) - R).norm(), 1e-9) << scale;
  }
}

TEST(NearestRotation, OfZeroIsThePreviousOne) {
  const Matrix3 previous = rotation_about({1, 2, 3}, 1);
  EXPECT_EQ(nearest_rotation(Matrix3::Zero(), previous), previous);
}

TEST(NearestRotationWithAxis, TurnsTheAxisAndMaximizesTheRest) {
  Random random(12);
  for (const auto& [name, S] : matrices()) {
    const Vector3 from = random.vector(1).normalized();
    const Vector3 to = random.vector(1).normalized();
    const Matrix3 R = nearest_rotation_with_axis(S, from, to, Matrix3::Identity());
    expect_rotation(R, name);
    EXPECT_LT((R * from - to).norm(), 1e-12) << name;
    for (int step = 0; step < 36; ++step) {
      const Matrix3 other = rotation_about(to, std::numbers::pi / 18 * step) * R;
      EXPECT_LE(product(other, S), product(R, S) + 1e-12 * S.norm()) << name;
    }
  }
}

TEST(NearestRotationWithAxis, WorksForEveryPairOfAxes) {
  const Matrix3 S = Vector3(3, 2, 1).asDiagonal();
  for (const Vector3& axis : {Vector3(Vector3::UnitX()), Vector3(Vector3::UnitY()), Vector3(Vector3::UnitZ()),
                              Vector3(Vector3(1, 1, 1).normalized())}) {
    for (const double sign : {1.0, -1.0}) {
      const Matrix3 R = nearest_rotation_with_axis(S, axis, sign * axis, Matrix3::Identity());
      expect_rotation(R, "same or opposite axis");
      EXPECT_LT((R * axis - sign * axis).norm(), 1e-13);
    }
  }
}

TEST(NearestRotationWithAxis, OfZeroStillTurnsTheAxis) {
  const Vector3 from = Vector3(1, 2, 3).normalized();
  const Vector3 to = Vector3(-2, 1, 1).normalized();
  const Matrix3 R = nearest_rotation_with_axis(Matrix3::Zero(), from, to, rotation_about({0, 1, 1}, .4));
  expect_rotation(R, "zero");
  EXPECT_LT((R * from - to).norm(), 1e-13);
}

}  // namespace
}  // namespace arap_test
