// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/rotation_vectors.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "support/helpers.h"

namespace arap_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Positions turns_about_z(std::initializer_list<double> degrees) {
  Positions result = Positions::Zero(static_cast<Eigen::Index>(degrees.size()), 3);
  Eigen::Index k = 0;
  for (const double angle : degrees) result(k++, 2) = angle * kDegree;
  return result;
}

Matrix3 about_z(double degrees) { return rotation_about(Vector3::UnitZ(), degrees * kDegree); }

TEST(RotationVectors, AreTheAxisTimesTheAngle) {
  Random random(7);
  for (int k = 0; k < 20; ++k) {
    const Vector3 turn = random.vector(1.7);
    const Matrix3 rotation = arap::rotation_by(turn).toRotationMatrix();
    EXPECT_LT((rotation - rotation_about(turn.normalized(), turn.norm())).norm(), 1e-14);
    EXPECT_LT((arap::rotation_vectors(std::array{Matrix3(3 * rotation)}).row(0).transpose() - turn).norm(), 1e-13);
  }
  EXPECT_LT((arap::rotation_by(450 * kDegree * Vector3::UnitZ()).toRotationMatrix() - about_z(90)).norm(), 1e-14);
  EXPECT_EQ(arap::rotation_by(Vector3::Zero()).toRotationMatrix(), Matrix3::Identity());
}

TEST(RotationVectors, LessIdentityAreRightAtAnyAngle) {
  const Vector3 axis = Vector3(1, -2, 3).normalized();
  // Series end just above half a turn.
  for (const double angle : {0.0, 1e-3, 1.0, 3.1415, 3.16, 3.17, 7.0}) {
    const Matrix3 expected = rotation_about(axis, angle) - Matrix3::Identity();
    EXPECT_LT((arap::rotation_less_identity(angle * axis) - expected).norm(), 1e-14) << angle;
  }
  // R itself would round there.
  const Matrix3 small = arap::rotation_less_identity(1e-12 * axis);
  EXPECT_LT(std::abs(small(2, 1) / (1e-12 * axis[0]) - 1), 1e-11);
}

TEST(RotationVectors, OfNearlyHalfATurnGoTheSameWay) {
  const Positions turns = arap::rotation_vectors(std::array{about_z(175), about_z(-175), about_z(-90)});
  EXPECT_LT(max_distance(turns, turns_about_z({175, 185, -90})), 1e-12);
}

TEST(RotationVectors, GoOnByWholeTurns) {
  Positions turns = turns_about_z({-90, 10, -170, 30, 0, -90, 90});
  arap::go_on_from(turns_about_z({170, 350, -530, 20, 720, -200, -350}), turns);
  EXPECT_LT(max_distance(turns, turns_about_z({270, 370, -530, 30, 720, -90, -270})), 1e-12);
}

TEST(RotationVectors, KeepTheWayTheyHaveInCommon) {
  Positions turns = turns_about_z({185, -175});
  arap::go_on_from(turns_about_z({0, 170}), turns);
  EXPECT_LT(max_distance(turns, turns_about_z({185, 185})), 1e-12);
}

}  // namespace
}  // namespace arap_test
