// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/cage_deformation/cage_fit.h"

#include <numeric>
#include <utility>
#include <vector>

#include "cages/cage_motion.h"

namespace arap {

std::vector<int> CageFit::all_points() const {
  std::vector<int> result(points_.size());
  std::iota(result.begin(), result.end(), 0);
  return result;
}

CageFit::Matrix CageFit::smoothing() const {
  const Cage& cage = points_.cage();
  const int c = cage.n_vertices();
  Matrix L = Matrix::Zero(c, c);
  for (const CageEdge& edge : cage.edges())
    for (const auto& [from, to] : {std::pair(edge.ends[0], edge.ends[1]), std::pair(edge.ends[1], edge.ends[0])})
      L(from, to) -= 1;
  int n_joined = 0;  // vertices in faces
  for (int v = 0; v < c; ++v) {
    const double n = -L.row(v).sum();
    if (!(n > 0)) continue;
    L.row(v) /= n;
    L(v, v) = 1;
    ++n_joined;
  }
  constexpr double kLeast = 1e-6;
  Matrix result = L.transpose() * L / n_joined;
  result.diagonal().array() += kLeast / n_joined;
  return result;
}

void CageFit::find_gram(const MeterPart& meter) const {
  {
    const std::scoped_lock lock(mutex_);
    if (gram_.size() != 0) return;
  }
  // Without the lock: the caller's progress may call this object, and other threads need not wait for it.
  const auto weights = Eigen::VectorXd::Constant(points_.size(), 1. / points_.size());
  Matrix gram =
      points_.normal_matrix(all_points(), weights, Eigen::RowVectorXd::Zero(points_.cage().n_vertices()), meter);
  Matrix of_edges = smoothing();
  const std::scoped_lock lock(mutex_);
  gram_ = std::move(gram);
  smoothing_ = std::move(of_edges);
}

void CageFit::factorize(double smoothness) const {
  if (smoothness == smoothness_) return;
  smoothness_ = 0;  // until there is a factor again
  factor_.compute(gram_ + smoothness * smoothing_);
  smoothness_ = smoothness;
}

Positions CageFit::fit(const Positions& positions, double smoothness, const MeterPart& meter) const {
  find_gram(meter);
  const std::scoped_lock lock(mutex_);
  factorize(smoothness);
  // In the input's unit: where points tell no scale, it stays.
  const double unit = points_.cage().size();
  const AffineMap map = best_similarity(unit * points_.rest(), positions);
  const Positions left = positions - map.apply(unit * points_.rest());
  const Matrix mean = points_.transposed(all_points(), left) / points_.size();
  return map.apply(unit * points_.cage().vertices()) + Positions(factor_.solve(mean));
}

}  // namespace arap
