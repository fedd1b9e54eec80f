// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/rotation.h"

#include <Eigen/Geometry>
#include <cmath>

#include "dense/small_matrices.h"
#include "geometry/fit_quaternion.h"

namespace arap {

namespace {

/// The exact fit, ten times slower than refine_rotation().
Matrix3 nearest_rotation_by_svd(const Matrix3& S, double scale, const Matrix3& previous) {
  // Scaled: the smallest covariances of a mesh are near the smallest doubles, where an SVD loses its digits.
  auto [values, U, V] = svd(S / scale);
  // Rank 1 determines the image of one axis, but not the rotation about it: keep that.
  constexpr double kRank = 1e-13;
  if (values[1] <= kRank * values[0]) return nearest_rotation_with_axis(previous, V.col(0), U.col(0), previous);
  if ((U * V.transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * V.transpose();
}

/// exp([w]) to third order of w and orthogonal to rounding: the Cayley transform of w / 2.
Matrix3 small_rotation(const Vector3& w) {
  const double x = 0.5 * w[0];
  const double y = 0.5 * w[1];
  const double z = 0.5 * w[2];
  const double scale = 2 / (1 + x * x + y * y + z * z);
  Matrix3 C;
  C << 1 - scale * (y * y + z * z), scale * (x * y - z), scale * (x * z + y),  //
      scale * (x * y + z), 1 - scale * (x * x + z * z), scale * (y * z - x),   //
      scale * (x * z - y), scale * (y * z + x), 1 - scale * (x * x + y * y);
  return C;
}

/// Newton's method on SO(3), starting from `R`. With M = R^T S the function <R exp([w]), S> has at w = 0 the gradient
/// vee(M - M^T) and the Hessian -H, H = tr(M) I - sym(M). The certificate: if the gradient vanishes and H is positive
/// definite, the sum of any two eigenvalues of M is positive, so R is the unique global maximum. Returns false if it
/// does not get there.
bool refine_rotation(const Matrix3& S, double scale, Matrix3& R) {
  constexpr int kMostSteps = 8;
  constexpr double kLargestTurn = 1.0;     // radians; beyond, the quadratic model means little
  constexpr double kLastTurn = 1e-8;       // Newton squares the error: after such a step it is rounding
  constexpr double kLeastDefinite = 1e-6;  // relative; below, the maximum is hardly unique
  for (int step = 0; step < kMostSteps; ++step) {
    const Matrix3 M = R.transpose() * S;
    Matrix3 H = -0.5 * (M + M.transpose());
    H.diagonal().array() += M.trace();
    // H = L D L^T: definite if its three pivots are positive.
    const double d0 = H(0, 0);
    if (!(d0 > kLeastDefinite * scale)) return false;
    const double l1 = H(1, 0) / d0;
    const double l2 = H(2, 0) / d0;
    const double d1 = H(1, 1) - l1 * H(1, 0);
    if (!(d1 > kLeastDefinite * scale)) return false;
    const double l21 = (H(2, 1) - l2 * H(1, 0)) / d1;
    const double d2 = H(2, 2) - l2 * H(2, 0) - l21 * l21 * d1;
    if (!(d2 > kLeastDefinite * scale)) return false;
    const double y0 = M(2, 1) - M(1, 2);
    const double y1 = M(0, 2) - M(2, 0) - l1 * y0;
    const double y2 = M(1, 0) - M(0, 1) - l2 * y0 - l21 * y1;
    Vector3 w;
    w[2] = y2 / d2;
    w[1] = y1 / d1 - l21 * w[2];
    w[0] = y0 / d0 - l1 * w[1] - l2 * w[2];
    const double turn = w.norm();
    if (turn > kLargestTurn) w *= kLargestTurn / turn;
    R = R * small_rotation(w);
    if (turn <= kLastTurn) {
      R = R * (1.5 * Matrix3::Identity() - 0.5 * (R.transpose() * R));  // keeps R orthogonal after many products
      return true;
    }
  }
  return false;
}

}  // namespace

Matrix3 nearest_rotation(const Matrix3& S, const Matrix3& previous) {
  const double scale = S.cwiseAbs().maxCoeff();
  if (!(scale > 0)) return previous;
  Matrix3 R = previous;
  return refine_rotation(S, scale, R) ? R : nearest_rotation_by_svd(S, scale, previous);
}

void fit_quaternion(const double* S, const double* former, double* quaternion) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> covariance(S);
  const Eigen::Quaterniond start(former[3], former[0], former[1], former[2]);
  // Normalized: for rank 1 the result builds on `former`, whose rounding would grow with every fit.
  const Eigen::Quaterniond fitted(nearest_rotation(covariance, start.normalized().toRotationMatrix()));
  Eigen::Vector4d::Map(quaternion) = fitted.normalized().coeffs();
}

Matrix3 rotation_between(const Vector3& from, const Vector3& to) {
  const Vector3 a = from.normalized();
  const Vector3 b = to.normalized();
  // Opposite ones tell no axis: about any one first, then by what is left, which is small and so well determined.
  constexpr double kOpposite = -1 + 1e-12;
  if (a.dot(b) < kOpposite) {
    const Vector3 axis = a.unitOrthogonal();
    return rotation_between(-a, b) * (2 * axis * axis.transpose() - Matrix3::Identity());
  }
  const Vector3 axis = a.cross(b);
  return Eigen::Quaterniond(1 + a.dot(b), axis[0], axis[1], axis[2]).normalized().toRotationMatrix();
}

Matrix3 nearest_rotation_with_axis(const Matrix3& S, const Vector3& from, const Vector3& to, const Matrix3& previous) {
  const Vector3 turned = previous * from;
  Matrix3 start = rotation_between(turned, to) * previous;
  // Rot(to, angle) * start: <., S> = cos * (tr M - to.M to) + sin * (to . vee M) + const with M = S start^T.
  const Matrix3 M = S * start.transpose();
  const Vector3 vee(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
  const double cosine = M.trace() - to.dot(M * to);
  const double sine = to.dot(vee);
  if (cosine * cosine + sine * sine <= 1e-28 * M.squaredNorm()) return start;
  return Eigen::AngleAxisd(std::atan2(sine, cosine), to).toRotationMatrix() * start;
}

}  // namespace arap
