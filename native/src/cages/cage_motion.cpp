// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_motion.h"

#include <algorithm>
#include <vector>

#include "dense/least_squares.h"
#include "geometry/rotation.h"

namespace arap {

namespace {

/// Sums over points from their means.
struct Moments {
  Vector3 rest_mean = Vector3::Zero();
  Vector3 moved_mean = Vector3::Zero();
  Matrix3 rest = Matrix3::Zero();     ///< sum x x^T
  Matrix3 between = Matrix3::Zero();  ///< sum x' x^T

  /// @param is_used  of each point; the others do not count
  Moments(const Positions& points, const Positions& moved, const std::vector<char>& is_used) {
    const auto n = static_cast<double>(std::count(is_used.begin(), is_used.end(), 1));
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
      if (is_used[v] == 0) continue;
      rest_mean += points.row(v).transpose() / n;
      moved_mean += moved.row(v).transpose() / n;
    }
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
      if (is_used[v] == 0) continue;
      const Vector3 x = points.row(v).transpose() - rest_mean;
      rest += x * x.transpose();
      between += (moved.row(v).transpose() - moved_mean) * x.transpose();
    }
  }

  [[nodiscard]] AffineMap map_of(const Matrix3& linear) const { return {linear, moved_mean - linear * rest_mean}; }

  [[nodiscard]] AffineMap similarity() const {
    // In any unit: a rotation is looked for by powers of what is given.
    const double unit = between.cwiseAbs().maxCoeff();
    const Matrix3 turn = nearest_rotation(between / (unit > 0 ? unit : 1), Matrix3::Identity());
    const double size = rest.trace();
    return map_of(size > 0 ? Matrix3(turn.cwiseProduct(between).sum() / size * turn) : turn);
  }
};

/// Of each vertex, whether it is in a triangle.
std::vector<char> used_vertices(const Cage& cage) {
  std::vector<char> is_used(cage.n_vertices(), 0);
  for (const CageTriangle& triangle : cage.triangles())
    for (const int v : triangle.vertices) is_used[v] = 1;
  return is_used;
}

}  // namespace

AffineMap best_affine_map(const Cage& cage, const Positions& moved) {
  const Moments moments(cage.vertices(), moved, used_vertices(cage));
  DenseLdlt factor;
  factor.compute(moments.rest);
  return moments.map_of(factor.solve(moments.between.transpose()).transpose());
}

Eigen::Matrix4Xd affine_fit(const Cage& cage) {
  const std::vector<char> is_used = used_vertices(cage);
  const Moments moments(cage.vertices(), cage.vertices(), is_used);
  DenseLdlt factor;
  factor.compute(moments.rest);
  const auto n = static_cast<double>(std::count(is_used.begin(), is_used.end(), 1));
  Eigen::Matrix4Xd result = Eigen::Matrix4Xd::Zero(4, cage.n_vertices());
  for (int v = 0; v < cage.n_vertices(); ++v) {
    if (is_used[v] == 0) continue;
    const Vector3 linear = factor.solve(cage.vertices().row(v).transpose() - moments.rest_mean);
    result.col(v) << 1 / n - moments.rest_mean.dot(linear), linear;
  }
  return result;
}

AffineMap best_similarity(const Cage& cage, const Positions& moved) {
  return Moments(cage.vertices(), moved, used_vertices(cage)).similarity();
}

AffineMap best_similarity(const Positions& rest, const Positions& moved) {
  return Moments(rest, moved, std::vector<char>(rest.rows(), 1)).similarity();
}

}  // namespace arap
