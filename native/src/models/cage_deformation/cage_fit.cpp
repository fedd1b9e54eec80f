// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/cage_deformation/cage_fit.h"

#include <algorithm>

#include "cages/cage_motion.h"

namespace arap {

namespace {

/// Points that are read at once.
constexpr int kRows = 256;

}  // namespace

CageFit::Matrix CageFit::gram() const {
  const int c = points_.cage().n_vertices();
  return parallel_reduce<16 * kRows>(
             points_.workers(), points_.size(), Matrix(Matrix::Zero(c, c)),
             [&](int begin, int end) {
               Matrix sum = Matrix::Zero(c, c);
               for (int first = begin; first < end; first += kRows) {
                 const CagePoints::Rows phi = points_.rows(first, std::min(kRows, end - first));
                 sum.selfadjointView<Eigen::Lower>().rankUpdate(phi.transpose());
               }
               return sum;
             },
             [](const Matrix& a, const Matrix& b) { return Matrix(a + b); }) /
         points_.size();
}

Positions CageFit::transposed(const Positions& x) const {
  Positions sum = Positions::Zero(points_.cage().n_vertices(), 3);
  for (int first = 0; first < points_.size(); first += kRows) {
    const int n = std::min(kRows, points_.size() - first);
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
    gram_ = gram();
    smoothing_ = smoothing();
  }
  if (smoothness == smoothness_) return;
  factor_.compute(gram_ + smoothness * smoothing_);
  smoothness_ = smoothness;
}

Positions CageFit::fit(const Positions& positions, double smoothness) const {
  const std::scoped_lock lock(mutex_);
  factorize(smoothness);
  const AffineMap map = best_similarity(points_.rest(), positions);
  const Positions left = positions - map.apply(points_.rest());
  return map.apply(points_.cage().vertices()) + Positions(factor_.solve(transposed(left)));
}

}  // namespace arap
