// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <mutex>
#include <vector>

#include "arap/types.h"
#include "cages/cage_points.h"
#include "dense/least_squares.h"
#include "parallel/meter.h"

namespace arap {

/// Finds the cage that brings its points to given places: see CageDeformation::fit(). The first call takes n c^2 steps
/// for n points and c vertices, and another smoothness c^3; several threads may call it.
class CageFit {
 public:
  /// @param points  linear in the cage; must outlive this
  explicit CageFit(const CagePoints& points) : points_(points) {}

  /// @param positions   (n, 3)
  /// @param smoothness  > 0
  [[nodiscard]] Positions fit(const Positions& positions, double smoothness, const MeterPart& meter = {}) const;

 private:
  using Matrix = Eigen::MatrixXd;

  [[nodiscard]] std::vector<int> all_points() const;
  /// L^T L over the number of vertices in faces, and a little that holds what neither points nor edges do.
  [[nodiscard]] Matrix smoothing() const;
  void find_gram(const MeterPart& meter) const;
  void factorize(double smoothness) const;

  const CagePoints& points_;
  mutable std::mutex mutex_;  ///< of all below
  mutable Matrix gram_;       ///< Phi^T Phi / n; made when first needed, as what follows
  mutable Matrix smoothing_;
  mutable double smoothness_ = 0;  ///< of the factor
  mutable DenseLdlt factor_;
};

}  // namespace arap
