// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "constraints/constrained_system.h"
#include "constraints/rigid_regions.h"

namespace arap {

/// Patches with vertices in a rigid region and others: a rotation of the region moves their averages, and their free
/// vertices then move to bring these back. What that costs is part of what the rotation costs.
///
/// Both simpler rules are worse. Held by its free vertices alone, a patch misses its target by a tenth of a pull and
/// more, and a rigid motion of all handles is no longer one of the mesh: a turn by 90 degrees dents it by up to 2 % of
/// the diagonal. If regions rotate as if there were no patch, iterations take six times as many.
///
/// With x the unknowns, A their matrix and R the region's rotation, the gaps of the patches are g(R) = h - R a, a their
/// arms; what closes them is P g, with P the responses; and it changes the energy by -<P g, r(R)> + 1/2 <g, M g>, with
/// M = P^T A P and the residual r(R) = k + R beta. All that is quadratic in R is a product of two vectors that R turns
/// alike, so it is constant: the cost is linear in R as the energy is, and the best R is exact.
class MixedPatches {
 public:
  /// None.
  MixedPatches() = default;
  /// @param patches  over vertices; those of the system are the same over unknowns. What no region has a vertex of is
  ///                 held still, and is none of these
  MixedPatches(const RigidRegions& regions, const std::vector<LinearRow>& patches, const ConstrainedSystem& system);

  [[nodiscard]] bool empty() const { return patches_.empty(); }
  /// Which of the given patches they are.
  [[nodiscard]] const std::vector<int>& patches() const { return patches_; }

  /// P^T r, (n_patches, 3): how much the energy falls where an average moves.
  /// @param residual  (n, 3), of vertices
  [[nodiscard]] Positions pulls(const Positions& residual) const;

  /// What closing the gaps adds to a region's linear term.
  /// @param rotation     of the region, where it has these gaps and pulls
  /// @param gaps, pulls  (n_patches, 3)
  [[nodiscard]] Matrix3 linear_term(int region, const Matrix3& rotation, const Positions& gaps,
                                    const Positions& pulls) const;

  /// Whether a turn of the region opens gaps.
  [[nodiscard]] bool feels(int region) const;

  /// Follows a change of a region's rotation.
  void follow_turn(int region, const Matrix3& change, Positions& pulls) const;

  /// Moves the free vertices such that the gaps close.
  void close(const Positions& gaps, Positions& pulls, Positions& positions) const;

 private:
  /// Of a patch, in a region.
  struct Lever {
    Vector3 arm;   ///< the average moves by R arm
    Vector3 pull;  ///< P^T beta: its pull changes by R pull
  };

  std::vector<int> patches_;
  Eigen::MatrixXd responses_;               ///< P, (n, n_patches), of vertices
  Eigen::MatrixXd stiffness_;               ///< M, (n_patches, n_patches)
  std::vector<std::vector<Lever>> levers_;  ///< of each patch, in each region
};

}  // namespace arap
