// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "geometry/rotation.h"

namespace arap {

namespace {

/// Sums over the vertices of a cage from their means.
struct Moments {
  Vector3 rest_mean = Vector3::Zero();
  Vector3 moved_mean = Vector3::Zero();
  Matrix3 rest = Matrix3::Zero();     ///< sum x x^T
  Matrix3 between = Matrix3::Zero();  ///< sum x' x^T

  Moments(const Cage& cage, const Positions& moved) {
    std::vector<char> is_used(cage.n_vertices(), 0);
    for (const CageTriangle& triangle : cage.triangles())
      for (const int v : triangle.vertices) is_used[v] = 1;
    const auto n = static_cast<double>(std::count(is_used.begin(), is_used.end(), 1));
    for (int v = 0; v < cage.n_vertices(); ++v) {
      if (is_used[v] == 0) continue;
      rest_mean += cage.vertices().row(v).transpose() / n;
      moved_mean += moved.row(v).transpose() / n;
    }
    for (int v = 0; v < cage.n_vertices(); ++v) {
      if (is_used[v] == 0) continue;
      const Vector3 x = cage.vertices().row(v).transpose() - rest_mean;
      rest += x * x.transpose();
      between += (moved.row(v).transpose() - moved_mean) * x.transpose();
    }
  }

  [[nodiscard]] AffineMap map_of(const Matrix3& linear) const { return {linear, moved_mean - linear * rest_mean}; }
};

}  // namespace

AffineMap best_affine_map(const Cage& cage, const Positions& moved) {
  const Moments moments(cage, moved);
  return moments.map_of(moments.rest.ldlt().solve(moments.between.transpose()).transpose());
}

AffineMap best_similarity(const Cage& cage, const Positions& moved) {
  const Moments moments(cage, moved);
  const Matrix3 turn = nearest_rotation(moments.between, Matrix3::Identity());
  return moments.map_of(turn.cwiseProduct(moments.between).sum() / moments.rest.trace() * turn);
}

}  // namespace arap
