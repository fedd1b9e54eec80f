// SPDX-License-Identifier: GPL-3.0-or-later
#include "rotation.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace arap {

Matrix3 nearest_rotation(const Matrix3& S, const Matrix3& previous) {
  const double scale = S.cwiseAbs().maxCoeff();
  if (!(scale > 0)) return previous;
  // Scaled: the smallest covariances of a mesh lie near the end of double's range, where an SVD loses its digits.
  const Eigen::JacobiSVD<Matrix3> svd(S / scale, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3 U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

Matrix3 nearest_rotation_with_axis(const Matrix3& S, const Vector3& from, const Vector3& to, const Matrix3& previous) {
  const Vector3 turned = previous * from;
  const Matrix3 start = Eigen::Quaterniond::FromTwoVectors(turned, to).toRotationMatrix() * previous;
  // Rot(to, angle) * start: <., S> = cos * (tr M - to.M to) + sin * (to . vee M) + const with M = S start^T.
  const Matrix3 M = S * start.transpose();
  const Vector3 vee(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
  const double cosine = M.trace() - to.dot(M * to);
  const double sine = to.dot(vee);
  if (std::hypot(cosine, sine) <= 1e-14 * M.norm()) return start;
  return Eigen::AngleAxisd(std::atan2(sine, cosine), to).toRotationMatrix() * start;
}

}  // namespace arap
