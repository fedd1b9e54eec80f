// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_sides.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "parallel/parallel.h"

namespace arap {

namespace {

/// Beyond so many of the triangle's longest edges a point does not keep its distance; from half of it on less and less.
constexpr double kFarthestInEdges = 4;
/// A point beside the triangle, as beyond the rim of an open surface, is on no side of it: the least distance from the
/// plane, of that from the triangle.
constexpr double kLeastAbove = .5;

/// The heights of a triangle that tells how it is stretched, at least, of its longest edge.
constexpr double kLeastHeight = .01;
/// Triangles that tell how the surface grows.
constexpr size_t kMostSamples = 150;
constexpr double kLeastGrowth = 1e-8;

/// A triangle at rest, its plane and the point: what the kernel wants of it.
class Side {
 public:
  /// One that does nothing.
  Side() : numbers_{1, 0, 0, 0, 1} { numbers_[side::kPerEdge] = 1; }

  /// @param away   distance of the point from the triangle
  /// @param above  its distance from the plane, < 0: behind it
  /// @param share  of what pushes it
  Side(const Vector3& ab, const Vector3& ac, const Vector3& place, double away, double above, double share) {
    const double longest = longest_edge(ab, ac);
    put(side::kAB, ab / longest);
    put(side::kAC, ac / longest);
    put(side::kPlace, place / longest);
    const double squared = ab.cross(ac).squaredNorm();
    if (squared >= std::pow(kLeastHeight * longest * longest, 2))
      put(side::kInverse, Vector3(ac.squaredNorm(), -ab.dot(ac), ab.squaredNorm()) * longest * longest / squared);
    numbers_[side::kDistance] = above / longest;
    numbers_[side::kStrength] = share * std::clamp(2 - 2 * away / (kFarthestInEdges * longest), 0., 1.);
    numbers_[side::kPerEdge] = 1 / longest;
  }

  [[nodiscard]] bool is_far() const { return !(numbers_[side::kStrength] > 0); }

  /// @param numbers  of the blocks
  void write(std::vector<float>& numbers, size_t point) const {
    float* block = numbers.data() + point / kWrapBlock * kSideNumbers * kWrapBlock + point % kWrapBlock;
    for (size_t i = 0; i < numbers_.size(); ++i) block[i * kWrapBlock] = static_cast<float>(numbers_[i]);
  }

 private:
  void put(int first, const Vector3& values) { std::copy(values.begin(), values.end(), numbers_.begin() + first); }

  std::array<double, kSideNumbers> numbers_{};
};

/// Of logarithms, about where they are densest: their mean, weighted by powers of how many there are around each. What
/// is held moves rigidly, so it decides, even if it is less than half of all. No choice between them, as of the densest
/// run, or all distances would jump when another one becomes the densest.
double most_common(const std::vector<double>& logarithms) {
  constexpr double kNear = .01;
  double weights = 0;
  double sum = 0;
  for (const double here : logarithms) {
    double around = 0;
    for (const double other : logarithms) {
      const double squared = std::pow((other - here) / kNear, 2);
      around += 1 / ((1 + squared) * (1 + squared));
    }
    // A fraction of all, whose powers are numbers. It decides in the same way.
    const double weight = std::pow(around / static_cast<double>(logarithms.size()), 8);
    weights += weight;
    sum += weight * here;
  }
  return sum / weights;
}

}  // namespace

SurfaceSides::SurfaceSides(const SurfaceTriangles& triangles, const Positions& points,
                           const std::vector<int>& nearest_node, const std::vector<double>& around, int threads,
                           UsedVertices& used) {
  if (triangles.is_empty()) return;
  const auto n = static_cast<int>(points.rows());
  const size_t n_blocks = (static_cast<size_t>(n) + kWrapBlock - 1) / kWrapBlock;
  numbers_.resize(n_blocks * kSideNumbers * kWrapBlock);
  for (size_t p = n; p < n_blocks * kWrapBlock; ++p) Side().write(numbers_, p);
  std::vector<int> triangle_of_point(n, -1);
  parallel_for(threads, n, [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      const Vector3 place = points.row(p).transpose();
      const SurfaceTriangles::Nearest nearest = triangles.nearest(nearest_node[p], place);
      const double away = std::sqrt(nearest.squared);
      Side its;
      if (nearest.triangle >= 0 && std::abs(nearest.above) + kWrapRounding >= kLeastAbove * away) {
        const auto [a, ab, ac] = triangles.at(nearest.triangle);
        its = Side(ab, ac, place - a, away, nearest.above, 1 - around[p]);
        if (!its.is_far()) triangle_of_point[p] = nearest.triangle;
      }
      its.write(numbers_, p);
    }
  });
  corners_.resize(n_blocks * 3 * kWrapBlock, 0);
  std::vector<size_t> near;  // points
  for (size_t p = 0; p < triangle_of_point.size(); ++p) {
    if (triangle_of_point[p] < 0) continue;
    near.push_back(p);
    int* block = corners_.data() + p / kWrapBlock * 3 * kWrapBlock + p % kWrapBlock;
    for (size_t i = 0; i < 3; ++i) block[i * kWrapBlock] = used.number_of(triangles.corners(triangle_of_point[p])[i]);
  }
  const size_t step = near.size() / kMostSamples + 1;
  for (size_t k = 0; k < near.size(); k += step) {
    const int triangle = triangle_of_point[near[k]];
    std::array<int, 3> corners = triangles.corners(triangle);
    for (int& corner : corners) corner = used.number_of(corner);
    const auto [a, ab, ac] = triangles.at(triangle);
    samples_.push_back({corners, ab, ac});
  }
}

double SurfaceSides::growth(const AlignedBuffer<double>& displacements) const {
  if (samples_.empty()) return 1;
  const auto displacement = [&](int k) { return Vector3::Map(&displacements[4 * static_cast<size_t>(k)]); };
  std::vector<double> logarithms;
  logarithms.reserve(samples_.size());
  for (const auto& [corners, ab, ac] : samples_) {
    const Vector3 u = displacement(corners[1]) - displacement(corners[0]);
    const Vector3 v = displacement(corners[2]) - displacement(corners[0]);
    const double growth = std::sqrt((ab + u).cross(ac + v).norm() / ab.cross(ac).norm());
    logarithms.push_back(std::log(std::clamp(growth, kLeastGrowth, 1 / kLeastGrowth)));
  }
  return std::exp(most_common(logarithms));
}

}  // namespace arap
