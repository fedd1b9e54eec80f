// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/wrap_points.h"

#include <algorithm>
#include <cmath>

#include "base/available_memory.h"
#include "base/eigen_compat.h"
#include "base/offsets.h"
#include "geometry/rotation.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

void require_memory_for(const SurfaceAtRest& surface, const Positions& points, int n_anchors) {
  constexpr double kBytesPerVertex = 30;  // which nodes and vertices are taken
  constexpr double kBytesPerAnchor = 60;  // of two levels, and while they are sorted
  require_memory(
      kBytesPerVertex * surface.n_vertices() + static_cast<double>(points.rows()) * (150 + kBytesPerAnchor * n_anchors),
      "so many points");
}

/// Vertices that tell the similarity: it need not be the very best.
constexpr size_t kMostFitted = 4096;

/// In sizes of the surface: from there on a point has the motion of the nearest place within. So squares of distances,
/// and what single precision makes of them, are numbers.
constexpr double kFarthest = 1e12;

Vector3 mean_of(const Positions& places) { return places.colwise().mean().transpose(); }

}  // namespace

WrapPoints::WrapPoints(const SurfaceAtRest& surface, const Positions& points, int n_anchors, bool stay_outside,
                       const std::vector<int>& piece_of_point, int requested_threads, const MeterPart& meter)
    : n_surface_vertices_(surface.n_vertices()),
      workers_(choose_threads(requested_threads, static_cast<int>(points.rows()))),
      size_(surface.size()) {
  require_memory_for(surface, points, n_anchors);
  rest_ = surface.in_frame(points);
  const Positions within = rest_.cwiseMax(-kFarthest).cwiseMin(kFarthest);
  single_rest_.reserve(4 * static_cast<size_t>(rest_.rows()));
  for (Eigen::Index p = 0; p < rest_.rows(); ++p) {
    for (int i = 0; i < 3; ++i) single_rest_.push_back(static_cast<float>(within(p, i)));
    single_rest_.push_back(1);
  }
  const int threads = workers_.threads();
  const SurfaceLevels& levels = surface.levels();
  const std::vector<AnchorLists> lists = find_anchors(surface, within, n_anchors, threads, meter.part(.7));
  UsedVertices used;
  maps_ = AnchorMaps(levels, set_weights(levels, lists), threads, used);
  meter.add(.15);
  if (stay_outside) {
    std::vector<int> nearest;
    std::vector<double> around;
    for (const AnchorLists& list : lists) {
      nearest.insert(nearest.end(), list.nearest.begin(), list.nearest.end());
      around.insert(around.end(), list.around.begin(), list.around.end());
    }
    sides_ = SurfaceSides(surface.triangles(), within, nearest, around, threads, used);
  }
  used_ = used.vertices();
  used_rest_ = surface.places()(used_, all);
  for (size_t k = 0; k < used_.size(); k += used_.size() / kMostFitted + 1) fitted_.push_back(static_cast<int>(k));
  const Positions fitted = used_rest_(fitted_, all);
  fitted_mean_ = mean_of(fitted);
  fitted_square_ = (fitted.rowwise() - fitted_mean_.transpose()).squaredNorm();
  set_pieces(points, piece_of_point);
  meter.add(.15);
}

std::vector<AnchorMaps::Node> WrapPoints::set_weights(const SurfaceLevels& levels,
                                                      const std::vector<AnchorLists>& lists) {
  std::vector<std::vector<int>> number;  // of each level and node
  number.reserve(levels.size());
  for (int l = 0; l < levels.size(); ++l) number.emplace_back(levels.level(l).n_nodes(), -1);
  std::vector<AnchorMaps::Node> anchors;
  offsets_.assign(1, 0);
  for (const AnchorLists& list : lists) offsets_.insert(offsets_.end(), list.counts.begin(), list.counts.end());
  make_offsets(offsets_);
  require_memory(static_cast<double>(offsets_.back()) * sizeof(AnchorWeight), "so many points");
  weights_.reserve(offsets_.back());
  for (const AnchorLists& list : lists)
    for (const PointAnchor& anchor : list.anchors) {
      int& its = number[anchor.level][anchor.node];
      if (its < 0) {
        its = static_cast<int>(anchors.size());
        anchors.push_back({anchor.level, anchor.node});
      }
      weights_.push_back({its, static_cast<float>(anchor.weight)});
    }
  return anchors;
}

WrapPoints::Frame WrapPoints::frame_of(const Positions& moved) const {
  // From the middle of the surface at rest, so that little is lost far from the origin.
  const Row middle = moved.row(0);
  const auto place_of = [&](int k) { return Vector3((moved.row(k) - middle).transpose() / size_); };
  Vector3 to = Vector3::Zero();
  Matrix3 products = Matrix3::Zero();
  for (const int k : fitted_) {
    to += place_of(k);
    products += place_of(k) * (used_rest_.row(k) - fitted_mean_.transpose());  // these sum to 0: place_of needs no mean
  }
  to /= static_cast<double>(fitted_.size());
  Frame frame;
  frame.rotation = nearest_rotation(products, Matrix3::Identity());
  constexpr double kLeastScale = 1e-6;
  double scale = fitted_square_ > 0 ? frame.rotation.cwiseProduct(products).sum() / fitted_square_ : 1;
  if (!(scale >= kLeastScale)) scale = 1;
  const auto n = static_cast<int>(used_.size());
  frame.displacements = AlignedBuffer<double>(4 * static_cast<size_t>(n));
  double* const displacements = frame.displacements.data();
  const Matrix3 back = frame.rotation.transpose() / scale;
  const double largest = parallel_reduce(
      workers_, n, 0.,
      [&](int begin, int end) {
        Eigen::Array3d longest = Eigen::Array3d::Zero();
        for (int k = begin; k < end; ++k) {
          const Vector3 move = back * (place_of(k) - to) + fitted_mean_ - used_rest_.row(k).transpose();
          double* const its = displacements + 4 * static_cast<size_t>(k);
          Vector3::Map(its) = move;
          its[3] = 0;
          longest = longest.max(move.array().abs());
        }
        return longest.maxCoeff();
      },
      [](double a, double b) { return std::max(a, b); });
  // Far beyond what single precision can hold.
  constexpr double kLargest = 1e12;
  if (largest > kLargest) {
    frame.unit = largest / kLargest;
    for (size_t i = 0; i < frame.displacements.size(); ++i) displacements[i] /= frame.unit;
  }
  frame.linear = scale * size_ * frame.rotation;
  frame.shift = size_ * (to - scale * (frame.rotation * fitted_mean_)) + middle.transpose();
  return frame;
}

void WrapPoints::set_pieces(const Positions& points, const std::vector<int>& piece_of_point) {
  std::vector<int> numbers;
  for (const int piece : piece_of_point)
    if (piece >= 0) numbers.push_back(piece);
  if (numbers.empty()) return;
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  n_pieces_ = static_cast<int>(numbers.size());
  const auto number_of = [&](int piece) {
    return static_cast<int>(std::lower_bound(numbers.begin(), numbers.end(), piece) - numbers.begin());
  };
  piece_offsets_.assign(n_pieces_ + 1, 0);
  for (const int piece : piece_of_point)
    if (piece >= 0) ++piece_offsets_[number_of(piece) + 1];
  make_offsets(piece_offsets_);
  std::vector<int> next(piece_offsets_.begin(), piece_offsets_.end() - 1);
  in_pieces_.resize(piece_offsets_.back());
  place_in_pieces_.assign(size(), -1);
  input_rest_.resize(piece_offsets_.back(), 3);
  for (int p = 0; p < size(); ++p) {
    if (piece_of_point[p] < 0) continue;
    const int place = next[number_of(piece_of_point[p])]++;
    in_pieces_[place] = p;
    place_in_pieces_[p] = place;
    input_rest_.row(place) = points.row(p);
  }
}

WrapPoints::Rigid WrapPoints::rigid_motion(int piece, const Positions& bent, const Matrix3& turn) const {
  const int begin = piece_offsets_[piece];
  const int n = piece_offsets_[piece + 1] - begin;
  const Positions before = input_rest_.middleRows(begin, n);
  const Positions after = bent.middleRows(begin, n);
  const Vector3 from = mean_of(before);
  const Vector3 to = mean_of(after);
  const Matrix3 S = (after.rowwise() - to.transpose()).transpose() * (before.rowwise() - from.transpose());
  return {nearest_rotation(S, turn), from, to};
}

}  // namespace arap
