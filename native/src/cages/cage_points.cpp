// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_points.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

#include "arap/error.h"
#include "base/available_memory.h"
#include "base/format_message.h"
#include "cages/cage_weights.h"
#include "cages/green.h"
#include "cages/harmonic.h"

namespace arap {

namespace {

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

/// Weights are as large as the distance.
void require_near(const Positions& points, const Cage& cage) {
  constexpr double kFarthest = 1e30;
  for (Eigen::Index k = 0; k < points.rows(); ++k)
    if (!(cage.to_cage(points.row(k)).norm() <= kFarthest))
      throw InvalidInput(text("points: row ", k, " is farther than 1e30 times the cage's size from it, where weights ",
                              "are beyond the range of single precision; leave it out"));
}

/// What n_weight_rows() says, if there is memory for so many points.
int checked_rows(const Cage& cage, CageCoordinates coordinates, Eigen::Index n_points) {
  const int n_rows = n_weight_rows(cage, coordinates);
  require_memory(WeightBlocks::bytes(static_cast<double>(n_points), n_rows), "this cage with so many points");
  return n_rows;
}

}  // namespace

CagePoints::CagePoints(const PolygonMesh& mesh, const Positions& points, const CageOptions& options,
                       const MeterPart& meter)
    : cage_(mesh),
      coordinates_(options.coordinates),
      workers_(choose_threads(options.threads, static_cast<int>(points.rows()))),
      rest_(points.rows(), 3),
      weights_(static_cast<int>(points.rows()), checked_rows(cage_, coordinates_, points.rows())),
      affine_(affine_fit(cage_)),
      affine_terms_(cage_.n_vertices(), 4) {
  require_near(points, cage_);
  affine_terms_ << Eigen::VectorXd::Ones(cage_.n_vertices()), cage_.vertices();
  for (Eigen::Index k = 0; k < points.rows(); ++k) rest_.row(k) = cage_.to_cage(points.row(k));
  const std::vector<int> outside =
      coordinates_ == CageCoordinates::kHarmonic
          ? harmonic_weights(cage_, options.grid_spacing, rest_, workers_, meter, weights_)
          : compute_weights(cage_, coordinates_, rest_, workers_.threads(), meter, weights_);
  require_none(outside, points.rows(), coordinates_);
}

AffineMap CagePoints::best_map(const Positions& moved) const {
  return coordinates_ == CageCoordinates::kGreen ? best_similarity(cage_, moved) : best_affine_map(cage_, moved);
}

Positions CagePoints::left_by(const AffineMap& map, const Positions& moved) const {
  Positions left(weights_.n_rows(), 3);
  const auto n = cage_.n_vertices();
  left.topRows(n) = moved - map.apply(cage_.vertices());
  if (coordinates_ == CageCoordinates::kGreen)
    left.bottomRows(cage_.n_triangles()) =
        stretched_normals(cage_, moved) - stretched_normals(cage_, cage_.vertices()) * map.linear.transpose();
  return left;
}

CagePoints::Rows CagePoints::rows(int first, int n) const {
  std::vector<int> points(n);
  std::iota(points.begin(), points.end(), first);
  return rows(points);
}

CagePoints::Rows CagePoints::rows(std::span<const int> points) const {
  const auto n = std::ssize(points);
  Rows result(n, cage_.n_vertices());
  // The best map is linear in the cage, too: what it does to a point, less what the weights do of that.
  Eigen::MatrixX4d beyond(n, 4);
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    result.row(k) = weights_.of_point(points[k]).transpose();
    beyond.row(k) << 1, rest_.row(points[k]);
  }
  beyond -= result * affine_terms_;
  result += beyond * affine_;
  return result;
}

Eigen::MatrixXd CagePoints::transposed(std::span<const int> points, const Eigen::MatrixXd& x) const {
  const auto n = static_cast<int>(points.size());
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(cage_.n_vertices(), x.cols());
  const Eigen::MatrixXd of_weights = parallel_reduce(
      workers_, n, none,
      [&](int begin, int end) {
        Eigen::MatrixXd sum = none;
        for (int k = begin; k < end; ++k) sum.noalias() += weights_.of_point(points[k]) * x.row(k);
        return sum;
      },
      [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return Eigen::MatrixXd(a + b); },
      std::max(kRows, n / kPartialSums + 1));
  // As in rows().
  Eigen::MatrixXd beyond = -affine_terms_.transpose() * of_weights;
  for (int k = 0; k < n; ++k) {
    beyond.row(0) += x.row(k);
    beyond.bottomRows<3>() += rest_.row(points[k]).transpose() * x.row(k);
  }
  return of_weights + affine_.transpose() * beyond;
}

Eigen::MatrixXd CagePoints::normal_matrix(std::span<const int> points, const Eigen::VectorXd& weights,
                                          const Eigen::RowVectorXd& about, const MeterPart& meter) const {
  const auto n = static_cast<int>(points.size());
  const double bytes = sizeof(double) * std::pow(cage_.n_vertices(), 2);
  constexpr int kOthers = 5;  // the sum twice, one that is made, and a factor
  require_memory(bytes * (std::min(kPartialSums, n / kRows + 1) + kOthers), "a cage of so many vertices");
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(cage_.n_vertices(), cage_.n_vertices());
  const auto lower = parallel_reduce(
      workers_, n, none,
      [&](int begin, int end) {
        Eigen::MatrixXd sum = none;
        for (int first = begin; first < end; first += kRows) {
          const int size = std::min(kRows, end - first);
          Rows scaled = rows(points.subspan(first, size)).rowwise() - about;
          scaled.array().colwise() *= weights.segment(first, size).array().sqrt();
          sum.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
          meter.add(static_cast<double>(size) / n);
        }
        return sum;
      },
      [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return Eigen::MatrixXd(a + b); },
      std::max(kRows, n / kPartialSums + 1));
  return lower.selfadjointView<Eigen::Lower>();
}

}  // namespace arap
