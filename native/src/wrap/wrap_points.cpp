// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/wrap_points.h"

#include <algorithm>
#include <cmath>

#include "base/available_memory.h"
#include "base/offsets.h"
#include "geometry/rotation.h"
#include "mesh/surface_measures.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

void require_memory_for(const PolygonMesh& surface, const Positions& points, int n_anchors) {
  constexpr double kBytesPerVertex = 1000;
  constexpr double kBytesPerAnchor = 60;  // of two levels, and while they are sorted
  require_memory(
      kBytesPerVertex * surface.n_vertices() + static_cast<double>(points.rows()) * (150 + kBytesPerAnchor * n_anchors),
      "this surface with so many points");
}

/// Sums over the used vertices.
struct Moments {
  Vector3 to = Vector3::Zero();
  Matrix3 products = Matrix3::Zero();

  void add(const Vector3& place, const Vector3& from_mean) {
    to += place;
    products += place * from_mean.transpose();  // from_mean sums to 0, so `place` needs no mean
  }
  Moments operator+(const Moments& other) const { return {to + other.to, products + other.products}; }
};

/// In sizes of the surface: from there on a point has the motion of the nearest place within. So squares of distances,
/// and what single precision makes of them, are numbers.
constexpr double kFarthest = 1e12;

Vector3 mean_of(const Positions& places) { return places.colwise().mean().transpose(); }

}  // namespace

WrapPoints::WrapPoints(const PolygonMesh& surface, const Positions& points, int n_anchors, bool stay_outside,
                       const std::vector<int>& piece_of_point, int requested_threads, const MeterPart& meter)
    : n_surface_vertices_(surface.n_vertices()),
      workers_(choose_threads(requested_threads, static_cast<int>(points.rows()))),
      center_(surface_box(surface).center().transpose()),
      size_(surface_box(surface).diagonal().norm()) {
  require_memory_for(surface, points, n_anchors);
  if (!(size_ > 0)) size_ = 1;
  const auto in_frame = [&](const Positions& places) { return Positions((places.rowwise() - center_) / size_); };
  rest_ = in_frame(points);
  const Positions within = rest_.cwiseMax(-kFarthest).cwiseMin(kFarthest);
  single_rest_.reserve(4 * static_cast<size_t>(rest_.rows()));
  for (Eigen::Index p = 0; p < rest_.rows(); ++p) {
    for (int i = 0; i < 3; ++i) single_rest_.push_back(static_cast<float>(within(p, i)));
    single_rest_.push_back(1);
  }
  const Positions places = in_frame(surface.positions());
  const int threads = workers_.threads();
  const SurfaceLevels levels(surface, places, threads, meter.part(.3));
  const std::vector<AnchorLists> lists = find_anchors(levels, within, n_anchors, threads, meter.part(.5));
  UsedVertices used;
  maps_ = AnchorMaps(levels, set_weights(levels, lists), threads, used);
  meter.add(.1);
  if (stay_outside) {
    std::vector<int> nearest;
    for (const AnchorLists& list : lists) nearest.insert(nearest.end(), list.nearest.begin(), list.nearest.end());
    sides_ = SurfaceSides(surface, levels, places, within, nearest, threads, used);
  }
  used_ = used.vertices();
  used_rest_ = places(used_, Eigen::all);
  used_mean_ = mean_of(used_rest_);
  used_square_ = (used_rest_.rowwise() - used_mean_.transpose()).squaredNorm();
  set_pieces(points, piece_of_point);
  meter.add(.1);
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
  Frame frame;
  const auto n = static_cast<int>(used_rest_.rows());
  Positions& places = frame.places;
  places.resize(n, 3);
  // From the middle of the surface at rest, so that little is lost far from the origin.
  const Row middle = moved.row(used_[0]);
  const Moments sums = parallel_reduce(
      workers_, n, Moments{},
      [&](int begin, int end) {
        Moments sum;
        for (int k = begin; k < end; ++k) {
          places.row(k) = (moved.row(used_[k]) - middle) / size_;
          sum.add(places.row(k).transpose(), used_rest_.row(k).transpose() - used_mean_);
        }
        return sum;
      },
      [](const Moments& a, const Moments& b) { return a + b; });
  const Vector3 to = sums.to / n;
  frame.rotation = nearest_rotation(sums.products, Matrix3::Identity());
  constexpr double kLeastScale = 1e-6;
  if (used_square_ > 0) frame.scale = frame.rotation.cwiseProduct(sums.products).sum() / used_square_;
  if (!(frame.scale >= kLeastScale)) frame.scale = 1;
  frame.rest_unit = 1 / frame.scale;
  frame.displacements = AlignedBuffer<double>(4 * static_cast<size_t>(n));
  const auto displacement = [&](int k) {
    return Eigen::Vector4d::Map(&frame.displacements[4 * static_cast<size_t>(k)]);
  };
  const Matrix3 back = frame.rotation.transpose() / frame.scale;
  const double largest = parallel_reduce(
      workers_, n, 0.,
      [&](int begin, int end) {
        double longest = 0;
        for (int k = begin; k < end; ++k) {
          const Vector3 place = back * (places.row(k).transpose() - to) + used_mean_;
          places.row(k) = place.transpose();
          displacement(k) << place - used_rest_.row(k).transpose(), 0;
          longest = std::max(longest, displacement(k).cwiseAbs().maxCoeff());
        }
        return longest;
      },
      [](double a, double b) { return std::max(a, b); });
  // Far beyond what single precision can hold.
  constexpr double kLargest = 1e12;
  if (largest > kLargest) frame.unit = largest / kLargest;
  if (frame.unit > 1)
    for (int k = 0; k < n; ++k) displacement(k) /= frame.unit;
  frame.shift = size_ * (to - frame.scale * (frame.rotation * used_mean_)) + middle.transpose();
  frame.scale *= size_;
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
