// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/lattice_fit.h"

#include <algorithm>

#include "base/eigen_compat.h"
#include "cholesky/preconditioned_cg.h"
#include "geometry/rotation.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Places of a piece beyond these tell nothing that its 27 control points could follow.
constexpr int kMostSamples = 32;

/// Stiffness of K beside that of a sample's area over the cube's size, which is about the same.
constexpr double kSmoothness = 1e-3;

}  // namespace

LatticeFit::LatticeFit(const Lattice& lattice, const std::vector<double>& areas, const Positions& rest,
                       const SparseMatrix& K)
    : lattice_(lattice), K_(K) {
  std::vector<int> n_vertices(lattice.n_pieces(), 0);
  for (const int piece : lattice.piece_of_vertex())
    if (piece >= 0) ++n_vertices[piece];
  LinearRows rows;
  std::vector<double> weights;
  const double h = lattice.cube_size();
  std::vector<int> n_seen(lattice.n_pieces(), 0);
  for (size_t v = 0; v < areas.size(); ++v) {
    const int piece = lattice.piece_of_vertex()[v];
    if (piece < 0) continue;
    const int step = (n_vertices[piece] + kMostSamples - 1) / kMostSamples;
    if (n_seen[piece]++ % step != 0) continue;
    samples_.push_back(static_cast<int>(v));
    rows.add(lattice.row(static_cast<int>(v)), 1);
    // A vertex without area, as of a face that is a line, has a place all the same.
    weights.push_back(step * (areas[v] / h + 1e-3 * h / n_vertices[piece]));
  }
  rest_ = rest(samples_, all);
  weights_ = Eigen::VectorXd::Map(weights.data(), static_cast<Eigen::Index>(weights.size()));
  rows_ = RowMatrix(rows, lattice.n_control_points());
  diagonal_ = kSmoothness * K.diagonal();
  for (int c = 0; c < lattice.n_control_points(); ++c)
    rows_.for_rows_of(c, [&](int row, double phi) { diagonal_[c] += weights_[row] * phi * phi; });
}

LatticeFit::Moments LatticeFit::moments(const Positions& points) const {
  Moments result(lattice_.n_control_points(), Eigen::Matrix<double, 16, 1>::Zero());
  for (int c = 0; c < lattice_.n_control_points(); ++c)
    rows_.for_rows_of(c, [&](int row, double phi) {
      const double weight = phi * weights_[row];
      const Vector3 from = rest_.row(row).transpose();
      const Vector3 to = points.row(samples_[row]).transpose();
      const Matrix3 product = to * from.transpose();
      result[c][0] += weight;
      result[c].segment<3>(1) += weight * from;
      result[c].segment<3>(4) += weight * to;
      result[c].segment<9>(7) += weight * product.reshaped();
    });
  return result;
}

void LatticeFit::spread(Moments& moments) const {
  constexpr int kMost = 100;
  constexpr double kShare = 0.5;  // of the mean of what is around it
  const Moments own = moments;
  // A place tells no turn, nor does a line of them: what is known is to go on as far as it came, and a little farther.
  int n_passes = kMost;
  for (int pass = 1; pass <= n_passes; ++pass) {
    const Moments before = moments;
    bool all_have_some = true;
    for (int c = 0; c < lattice_.n_control_points(); ++c) {
      Eigen::Matrix<double, 16, 1> around = Eigen::Matrix<double, 16, 1>::Zero();
      int n = 0;
      for (SparseMatrix::InnerIterator it(K_, c); it; ++it)
        if (it.row() != c) {
          around += before[it.row()];
          ++n;
        }
      moments[c] = own[c] + kShare / std::max(1, n) * around;
      all_have_some = all_have_some && moments[c][0] > 0;
    }
    if (all_have_some && n_passes == kMost) n_passes = std::min(kMost, 2 * pass + 3);
  }
}

void LatticeFit::correct(const Positions& points, const Workers& workers, Positions& control_points) const {
  constexpr double kAccuracy = 1e-3;  // of the correction
  const Positions left = rows_.gaps(points(samples_, all), control_points, workers);
  Positions correction = Positions::Zero(control_points.rows(), 3);
  rows_.add_transposed(weights_.asDiagonal() * left, correction, workers);
  Positions of_samples;
  const auto apply = [&](const Positions& x, Positions& y) {
    multiply(K_, x, y, workers);
    y *= kSmoothness;
    rows_.multiply(x, of_samples, workers);
    of_samples.array().colwise() *= weights_.array();
    rows_.add_transposed(of_samples, y, workers);
  };
  const auto solve = [&](const Positions& residual, Positions& x) {
    x = diagonal_.cwiseInverse().asDiagonal() * residual;
  };
  solve_with_cg(apply, solve, correction, workers, kAccuracy);
  control_points += correction;
}

Positions LatticeFit::fit(const Positions& points, const Workers& workers) const {
  Moments sums = moments(points);
  spread(sums);
  Positions result = lattice_.rest();
  parallel_for(workers, lattice_.n_control_points(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      if (!(sums[c][0] > 0)) continue;
      const Vector3 from = sums[c].segment<3>(1) / sums[c][0];
      const Vector3 to = sums[c].segment<3>(4) / sums[c][0];
      const Matrix3 product = sums[c].segment<9>(7).reshaped(3, 3) / sums[c][0] - to * from.transpose();
      const Matrix3 turn = nearest_rotation(product, Matrix3::Identity());
      result.row(c) = (to + turn * (lattice_.rest().row(c).transpose() - from)).transpose();
    }
  });
  correct(points, workers, result);
  return result;
}

}  // namespace arap
