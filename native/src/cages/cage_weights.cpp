// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_weights.h"

#include <algorithm>
#include <array>

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

/// Calls of_block(b, first, n): block b has n points from `first` on.
template <class OfBlock>
void for_each_block(const WeightBlocks& weights, int begin, int end, const OfBlock& of_block) {
  for (int b = begin; b < end; ++b) {
    const int first = b * kCageBlock;
    of_block(b, first, std::min(kCageBlock, weights.n_points() - first));
  }
}

/// Blocks of mean value coordinates, with what one thread needs for them.
class MeanValueBlocks {
 public:
  MeanValueBlocks(const Cage& cage, const Positions& points, const CageKernels& kernels)
      : cage_(cage),
        points_(points),
        kernels_(kernels),
        scratch_((cage.edges().size() + static_cast<size_t>(cage.n_vertices())) * kCageBlock) {}

  void compute(int first, int n, float* weights) {
    std::array<double, 3 * kCageBlock> coordinates{};
    for (int lane = 0; lane < kCageBlock; ++lane)  // beyond the last point that once more
      for (int k = 0; k < 3; ++k) coordinates[kCageBlock * k + lane] = points_(first + std::min(lane, n - 1), k);
    const unsigned unsure = kernels_.mean_values(cage_.view(), coordinates.data(), scratch_.data(), weights);
    for (int lane = 0; lane < n; ++lane)
      if ((unsure >> static_cast<unsigned>(lane) & 1U) != 0)
        put(mean_value_coordinates(cage_, points_.row(first + lane)), lane, weights);
  }

 private:
  const Cage& cage_;
  const Positions& points_;
  const CageKernels& kernels_;
  std::vector<double> scratch_;
};

}  // namespace

int n_weight_rows(const Cage& cage, CageCoordinates coordinates) {
  return cage.n_vertices() + (coordinates == CageCoordinates::kGreen ? cage.n_triangles() : 0);
}

std::vector<int> compute_weights(const Cage& cage, CageCoordinates coordinates, const Positions& points, int threads,
                                 const MeterPart& meter, WeightBlocks& weights, Isa isa) {
  const CageKernels& own = kernels(isa).cage;
  std::vector<char> has_none(static_cast<size_t>(points.rows()), 0);
  const auto green = [&](int first, int n, float* rows) {
    for (int lane = 0; lane < n; ++lane) {
      const GreenCoordinates of_point = green_coordinates(cage, points.row(first + lane));
      has_none[first + lane] = of_point.is_inside ? 0 : 1;
      if (!of_point.is_inside) continue;
      put(of_point.vertices, lane, rows);
      put(of_point.triangles, lane, rows + std::ptrdiff_t{kCageBlock} * cage.n_vertices());
    }
  };
  parallel_for<kBlocks>(threads, weights.n_blocks(), [&](int begin, int end) {
    MeanValueBlocks mean_values(cage, points, own);
    for_each_block(weights, begin, end, [&](int b, int first, int n) {
      if (coordinates == CageCoordinates::kGreen)
        green(first, n, weights.block(b));
      else
        mean_values.compute(first, n, weights.block(b));
    });
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
