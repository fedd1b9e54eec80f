// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "arap/cage.h"
#include "base/available_memory.h"
#include "cages/cage.h"
#include "cages/cage_motion.h"
#include "cages/cage_weights.h"
#include "cages/green.h"
#include "cages/harmonic.h"
#include "cages/weight_blocks.h"
#include "kernels/kernels.h"
#include "models/input_checks.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

void require_points(const Positions& points) {
  if (points.rows() == 0) throw InvalidInput("points is empty; give at least one point for the cage to move");
  if (points.rows() > kMostVertices)
    throw InvalidInput(text("points has ", points.rows(), " rows, must have at most ", kMostVertices));
  require_finite("points", points, [](int k) { return text("row ", k); });
}

void require_moved(const Positions& cage_positions, int n_vertices) {
  require_rows("cage_positions", cage_positions.rows(), n_vertices);
  require_finite("cage_positions", cage_positions, [](int v) { return text("vertex ", v); });
}

/// Tells which points a cage cannot carry.
void require_none(const std::vector<int>& outside, Eigen::Index n_points, CageCoordinates coordinates) {
  if (outside.empty()) return;
  constexpr size_t kMostNamed = 5;
  std::string named;
  for (size_t k = 0; k < std::min(outside.size(), kMostNamed); ++k) named += text(k == 0 ? "" : ", ", outside[k]);
  if (outside.size() > kMostNamed) named += ", ...";
  throw InvalidInput(text(outside.size(), " of ", n_points, " points are not inside of the cage (", named,
                          "), where there are no ", coordinates == CageCoordinates::kGreen ? "Green" : "harmonic",
                          " coordinates; make the cage larger or take mean value coordinates"));
}

}  // namespace

void CageOptions::validate() const {
  constexpr double kFinest = .005;
  constexpr double kCoarsest = .1;
  if (!(grid_spacing >= kFinest && grid_spacing <= kCoarsest))
    throw InvalidInput(text("grid_spacing = ", grid_spacing, ", must be >= ", kFinest, " and <= ", kCoarsest));
  require_threads(threads);
}

struct CageDeformation::Impl {
  Impl(const PolygonMesh& mesh, const Positions& points, const CageOptions& options, const Progress& progress)
      : cage(mesh),
        coordinates(options.coordinates),
        workers(choose_threads(options.threads, static_cast<int>(points.rows()))),
        rest(points.rows(), 3),
        weights(static_cast<int>(points.rows()), n_weight_rows(cage, coordinates)) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) rest.row(k) = cage.to_cage(points.row(k));
    Meter meter(progress, "computing the weights of the cage was cancelled");
    const std::vector<int> outside =
        coordinates == CageCoordinates::kHarmonic
            ? harmonic_weights(cage, options.grid_spacing, rest, workers, {&meter, 1}, weights)
            : compute_weights(cage, coordinates, rest, workers.threads(), {&meter, 1}, weights);
    require_none(outside, points.rows(), coordinates);
    meter.reach(1);
  }

  /// What the best map leaves of the motion of the cage: vectors that the weights are multiplied by.
  [[nodiscard]] Positions left_by(const AffineMap& map, const Positions& moved) const {
    Positions left(weights.n_rows(), 3);
    const auto n = cage.n_vertices();
    left.topRows(n) = moved - map.apply(cage.vertices());
    if (coordinates == CageCoordinates::kGreen)
      left.bottomRows(cage.n_triangles()) =
          stretched_normals(cage, moved) - stretched_normals(cage, cage.vertices()) * map.linear.transpose();
    return left;
  }

  /// Calls put(point, place) for all points.
  template <class Put>
  void deform(const Positions& moved, const Put& put) const {
    const AffineMap map =
        coordinates == CageCoordinates::kGreen ? best_similarity(cage, moved) : best_affine_map(cage, moved);
    const Positions left = left_by(map, moved);
    const CageKernels& own = kernels(isa).cage;
    parallel_for<kBlocks>(workers, weights.n_blocks(), [&](int begin, int end) {
      for (int b = begin; b < end; ++b) {
        std::array<double, 3 * kCageBlock> sums{};
        own.carry(weights.block(b), left.data(), weights.n_rows(), sums.data());
        for (int lane = 0; lane < kCageBlock; ++lane) {
          const int p = b * kCageBlock + lane;
          if (p >= weights.n_points()) break;
          const Vector3 carried(sums[lane], sums[kCageBlock + lane], sums[2 * kCageBlock + lane]);
          put(p, Vector3(map.linear * rest.row(p).transpose() + map.shift + carried));
        }
      }
    });
  }

  static constexpr int kBlocks = 16;  ///< that a thread takes at a time

  Cage cage;
  CageCoordinates coordinates;
  Isa isa = choose_isa();
  Workers workers;
  Positions rest;  ///< of the points, in the cage's space
  WeightBlocks weights;
};

CageDeformation::CageDeformation(const PolygonMesh& cage, const Positions& points, const CageOptions& options,
                                 const Progress& progress) {
  options.validate();
  require_points(points);
  // A quad may have four triangles.
  const double n_rows = cage.n_vertices() + (options.coordinates == CageCoordinates::kGreen ? 4.0 * cage.n_faces() : 0);
  require_memory(WeightBlocks::bytes(static_cast<double>(points.rows()), n_rows), "this cage with so many points");
  impl_ = std::make_unique<Impl>(cage, points, options, progress);
}

CageDeformation::~CageDeformation() = default;
CageDeformation::CageDeformation(CageDeformation&&) noexcept = default;
CageDeformation& CageDeformation::operator=(CageDeformation&&) noexcept = default;

Positions CageDeformation::deform(const Positions& cage_positions) const {
  require_moved(cage_positions, n_vertices());
  Positions result(n_points(), 3);
  impl_->deform(cage_positions, [&](int p, const Vector3& place) { result.row(p) = place.transpose(); });
  return result;
}

void CageDeformation::deform(const Positions& cage_positions, std::span<float> out) const {
  require_moved(cage_positions, n_vertices());
  const size_t n_numbers = 3 * static_cast<size_t>(n_points());
  if (out.size() != n_numbers)
    throw InvalidInput(text("out has ", out.size(), " numbers, must have three per point, ", n_numbers));
  impl_->deform(cage_positions, [&](int p, const Vector3& place) {
    for (int k = 0; k < 3; ++k) out[3 * static_cast<size_t>(p) + k] = static_cast<float>(place[k]);
  });
}

CageWeights CageDeformation::weights(int point) const {
  if (point < 0 || point >= n_points())
    throw InvalidInput(text("point ", point, " is not there, there are points 0 to ", n_points() - 1));
  if (impl_->coordinates != CageCoordinates::kHarmonic)
    return weights_of(impl_->cage, impl_->coordinates, impl_->rest.row(point));
  CageWeights stored{impl_->weights.of_point(point), {}};
  repair_weights(impl_->cage, impl_->rest.row(point), stored.vertices);
  return stored;
}

int CageDeformation::n_points() const { return impl_->weights.n_points(); }
int CageDeformation::n_vertices() const { return impl_->cage.n_vertices(); }
int CageDeformation::n_triangles() const { return impl_->cage.n_triangles(); }
int CageDeformation::threads() const { return impl_->workers.threads(); }

}  // namespace arap
