// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "arap/cage.h"
#include "arap/mesh.h"
#include "arap/types.h"
#include "cages/cage.h"
#include "cages/cage_motion.h"
#include "cages/weight_blocks.h"
#include "kernels/kernels.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "parallel/workers.h"

namespace arap {

/// Points that a cage carries, and their weights. The motion that fits the cage's best, affine or for kGreen a
/// similarity, moves the points in double; the weights, in single precision, carry what it leaves.
class CagePoints {
 public:
  /// (m, n_vertices)
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Throws as CageDeformation does for these arguments.
  CagePoints(const PolygonMesh& mesh, const Positions& points, const CageOptions& options, const MeterPart& meter);

  [[nodiscard]] const Cage& cage() const { return cage_; }
  [[nodiscard]] CageCoordinates coordinates() const { return coordinates_; }
  [[nodiscard]] const Workers& workers() const { return workers_; }
  [[nodiscard]] int size() const { return weights_.n_points(); }
  /// (n, 3) of the points, in the cage's space.
  [[nodiscard]] const Positions& rest() const { return rest_; }
  /// As they are stored.
  [[nodiscard]] const WeightBlocks& weights() const { return weights_; }

  /// Calls put(point, place) for all points.
  /// @param moved  (n_vertices, 3) of the cage
  template <class Put>
  void deform(const Positions& moved, const Put& put) const {
    const AffineMap map = best_map(moved);
    const Positions left = left_by(map, moved);
    const CageKernels& own = kernels(isa_).cage;
    parallel_for<kBlocks>(workers_, weights_.n_blocks(), [&](int begin, int end) {
      for (int b = begin; b < end; ++b) {
        std::array<double, kSums> sums{};
        own.carry(weights_.block(b), left.data(), weights_.n_rows(), sums.data());
        for (int lane = 0; lane < kCageBlock; ++lane) {
          const int p = b * kCageBlock + lane;
          if (p >= size()) break;
          const Vector3 carried(sums[lane], sums[kCageBlock + lane], sums[2 * kCageBlock + lane]);
          put(p, Vector3(map.linear * rest_.row(p).transpose() + map.shift + carried));
        }
      }
    });
  }

  /// Rows `first` to `first` + n - 1 of Phi in p' = Phi c': what deform() does. Not for kGreen, which is not linear in
  /// the cage.
  [[nodiscard]] Rows rows(int first, int n) const;
  /// The same of any points.
  [[nodiscard]] Rows rows(std::span<const int> points) const;
  /// Phi^T x of some points, (n_vertices, k).
  /// @param x  (n_points, k)
  [[nodiscard]] Eigen::MatrixXd transposed(std::span<const int> points, const Eigen::MatrixXd& x) const;
  /// The sum of w (phi - about)^T (phi - about) over some points, (n_vertices, n_vertices).
  /// @param weights  (n_points,) w
  /// @param about    (n_vertices,) taken from each row phi
  /// Throws Cancelled, or NotEnoughMemory: there must be enough for a factor of it, too.
  [[nodiscard]] Eigen::MatrixXd normal_matrix(std::span<const int> points, const Eigen::VectorXd& weights,
                                              const Eigen::RowVectorXd& about, const MeterPart& meter) const;

  /// Points whose rows are made at once: they stay in the cache.
  static constexpr int kRows = 256;

 private:
  static constexpr int kPartialSums = 8;                                ///< that there is memory for
  static constexpr int kBlocks = 16;                                    ///< that a thread takes at a time
  static constexpr size_t kSums = static_cast<size_t>(3) * kCageBlock;  ///< of a block

  [[nodiscard]] AffineMap best_map(const Positions& moved) const;
  /// What the best map leaves of the motion of the cage: vectors that the weights are multiplied by.
  [[nodiscard]] Positions left_by(const AffineMap& map, const Positions& moved) const;

  Cage cage_;
  CageCoordinates coordinates_;
  Isa isa_ = choose_isa();
  Workers workers_;
  Positions rest_;
  WeightBlocks weights_;
  Eigen::Matrix4Xd affine_;        ///< affine_fit()
  Eigen::MatrixX4d affine_terms_;  ///< (n_vertices, 4) of the cage: 1 and the place
};

}  // namespace arap
