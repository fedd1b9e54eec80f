// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/cage_deformation/cage_fit.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "cages/cage_motion.h"

namespace arap {

Positions CageFit::transposed(const Positions& x) const {
  Positions sum = Positions::Zero(points_.cage().n_vertices(), 3);
  for (int first = 0; first < points_.size(); first += CagePoints::kRows) {
    const int n = std::min(CagePoints::kRows, points_.size() - first);
    sum += points_.rows(first, n).transpose() * x.middleRows(first, n);
  }
  return sum / points_.size();
}

CageFit::Matrix CageFit::smoothing() const {
  const Cage& cage = points_.cage();
  const int c = cage.n_vertices();
  Matrix L = Matrix::Zero(c, c);
  for (const CageEdge& edge : cage.edges())
    for (const auto& [from, to] : {std::pair(edge.ends[0], edge.ends[1]), std::pair(edge.ends[1], edge.ends[0])})
      L(from, to) -= 1;
  for (int v = 0; v < c; ++v) {
    const double n = -L.row(v).sum();
    if (n > 0) L.row(v) /= n;
    L(v, v) = n > 0 ? 1 : 0;
  }
  constexpr double kLeast = 1e-6;
  Matrix result = L.transpose() * L / c;
  result.diagonal().array() += kLeast / c;
  return result;
}

void CageFit::factorize(double smoothness) const {
  if (gram_.size() == 0) {
    std::vector<int> all_points(points_.size());
    std::iota(all_points.begin(), all_points.end(), 0);
    gram_ = points_.normal_matrix(all_points, Eigen::VectorXd::Constant(points_.size(), 1. / points_.size()));
    smoothing_ = smoothing();
  }
  if (smoothness == smoothness_) return;
  factor_.compute(gram_ + smoothness * smoothing_);
  smoothness_ = smoothness;
}

Positions CageFit::fit(const Positions& positions, double smoothness) const {
  const std::scoped_lock lock(mutex_);
  factorize(smoothness);
  // In the input's unit: where points tell no scale, it stays.
  const double unit = points_.cage().size();
  const AffineMap map = best_similarity(unit * points_.rest(), positions);
  const Positions left = positions - map.apply(unit * points_.rest());
  return map.apply(unit * points_.cage().vertices()) + Positions(factor_.solve(transposed(left)));
}

}  // namespace arap
