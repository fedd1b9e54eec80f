// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_weights.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cages/green.h"
#include "cages/mean_value.h"
#include "kernels/kernels.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Blocks that a thread takes at a time.
constexpr int kBlocks = 8;

void put(const Eigen::VectorXd& values, int lane, float* rows) {
  for (Eigen::Index k = 0; k < values.size(); ++k) rows[kCageBlock * k + lane] = static_cast<float>(values[k]);
}

/// Computes blocks of weights, with what one thread needs for that.
class BlockWeights {
 public:
  BlockWeights(const Cage& cage, CageCoordinates coordinates, const Positions& points, const CageKernels& kernels)
      : cage_(cage),
        coordinates_(coordinates),
        points_(points),
        compute_(coordinates == CageCoordinates::kGreen ? kernels.green : kernels.mean_values),
        scratch_(2 * (cage.edges().size() + static_cast<size_t>(cage.n_vertices())) * kCageBlock) {}

  /// Of n points from `first` on. Calls has_none(point) for those without weights.
  template <class HasNone>
  void compute(int first, int n, float* weights, const HasNone& has_none) {
    std::array<double, 3 * kCageBlock> coordinates{};
    for (int lane = 0; lane < kCageBlock; ++lane)  // beyond the last point that once more
      for (int k = 0; k < 3; ++k) coordinates[kCageBlock * k + lane] = points_(first + std::min(lane, n - 1), k);
    const unsigned unsure = compute_(cage_.view(), coordinates.data(), scratch_.data(), weights);
    for (int lane = 0; lane < n; ++lane)
      if ((unsure >> static_cast<unsigned>(lane) & 1U) != 0 && !compute_exactly(first + lane, lane, weights))
        has_none(first + lane);
  }

 private:
  bool compute_exactly(int point, int lane, float* weights) {
    if (coordinates_ == CageCoordinates::kMeanValue) {
      put(mean_value_coordinates(cage_, points_.row(point)), lane, weights);
      return true;
    }
    const GreenCoordinates green = green_coordinates(cage_, points_.row(point));
    put(green.vertices, lane, weights);
    put(green.triangles, lane, weights + std::ptrdiff_t{kCageBlock} * cage_.n_vertices());
    return green.is_inside;
  }

  const Cage& cage_;
  CageCoordinates coordinates_;
  const Positions& points_;
  unsigned (*compute_)(const CageView& cage, const double* points, double* scratch, float* weights);
  std::vector<double> scratch_;
};

}  // namespace

int n_weight_rows(const Cage& cage, CageCoordinates coordinates) {
  return cage.n_vertices() + (coordinates == CageCoordinates::kGreen ? cage.n_triangles() : 0);
}

std::vector<int> compute_weights(const Cage& cage, CageCoordinates coordinates, const Positions& points, int threads,
                                 const MeterPart& meter, WeightBlocks& weights, Isa isa) {
  std::vector<char> has_none(static_cast<size_t>(points.rows()), 0);
  parallel_for<kBlocks>(threads, weights.n_blocks(), [&](int begin, int end) {
    BlockWeights of_block(cage, coordinates, points, kernels(isa).cage);
    for (int b = begin; b < end; ++b) {
      const int first = b * kCageBlock;
      of_block.compute(first, std::min(kCageBlock, weights.n_points() - first), weights.block(b),
                       [&](int point) { has_none[point] = 1; });
    }
    meter.add(static_cast<double>(end - begin) / weights.n_blocks());
  });
  std::vector<int> without;
  for (int p = 0; p < static_cast<int>(points.rows()); ++p)
    if (has_none[p] != 0) without.push_back(p);
  return without;
}

CageWeights weights_of(const Cage& cage, CageCoordinates coordinates, const Eigen::RowVector3d& point) {
  if (coordinates == CageCoordinates::kMeanValue) return {mean_value_coordinates(cage, point), {}};
  GreenCoordinates green = green_coordinates(cage, point);
  return {std::move(green.vertices), cage.size() * green.triangles};
}

}  // namespace arap
