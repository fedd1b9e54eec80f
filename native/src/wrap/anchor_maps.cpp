// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/anchor_maps.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/offsets.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Neighbours that are so nearly on a line tell only how the line moves. Of the eigenvalues of sum e e^T / |e|^2.
constexpr double kLeastAcross = 1e-3;
/// Steps to more neighbours if the first ones are on a line.
constexpr int kMostSteps = 4;

/// Of unit edges e: what they span.
struct Span {
  Vector3 u = Vector3::Zero();
  Vector3 v = Vector3::Zero();
  Matrix3 inverse = Matrix3::Zero();  ///< of sum e e^T, in the span
};

Span span_of(const std::vector<Vector3>& directions) {
  Span span;
  Matrix3 sum = Matrix3::Zero();
  for (const Vector3& e : directions) sum += e * e.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(sum);
  const Vector3& values = eigen.eigenvalues();
  if (!(values[2] > 0)) return span;
  span.u = eigen.eigenvectors().col(2);
  span.inverse = span.u * span.u.transpose() / values[2];
  if (!(values[1] >= kLeastAcross * values[2])) return span;
  span.v = eigen.eigenvectors().col(1);
  span.inverse += span.v * span.v.transpose() / values[1];
  return span;
}

/// An anchor's neighbours, more steps away where the next ones do not span a plane.
class Ring {
 public:
  Ring() = default;
  Ring(const SurfaceLevel& level, int anchor) : nodes_{anchor} {
    size_t begin = 0;
    for (int step = 0; step < kMostSteps && span_.v.isZero(0); ++step) {
      const size_t end = nodes_.size();
      for (size_t k = begin; k < end; ++k)
        for (const int other : level.around(nodes_[k]))
          if (std::find(nodes_.begin(), nodes_.end(), other) == nodes_.end()) nodes_.push_back(other);
      begin = end;
      if (nodes_.size() > end) measure(level);
    }
  }

  [[nodiscard]] const Span& span() const { return span_; }
  [[nodiscard]] size_t size() const { return directions_.size(); }
  [[nodiscard]] int node(size_t k) const { return nodes_[k + 1]; }
  [[nodiscard]] Vector3 gradient(size_t k) const { return span_.inverse * directions_[k] / lengths_[k]; }

 private:
  void measure(const SurfaceLevel& level) {
    directions_.clear();
    lengths_.clear();
    for (size_t k = 1; k < nodes_.size(); ++k) {
      const Vector3 edge = (level.places.row(nodes_[k]) - level.places.row(nodes_[0])).transpose();
      lengths_.push_back(edge.norm());  // > 0: there is one node at a place
      directions_.emplace_back(edge / lengths_.back());
    }
    span_ = span_of(directions_);
  }

  std::vector<int> nodes_;  ///< the anchor first
  std::vector<Vector3> directions_;
  std::vector<double> lengths_;
  Span span_;
};

/// D of the turn and growth that bring u to u + change, and turn nothing else.
Matrix3 turn_of_line(const Vector3& u, const Vector3& change) {
  const Vector3 moved = u + change;
  const double growth = moved.norm() / u.norm();  // u may be rounded
  if (!(growth > 0)) return Matrix3::Zero();
  return growth * Eigen::Quaterniond::FromTwoVectors(u, moved).toRotationMatrix() - Matrix3::Identity();
}

/// What brings the normal n = u x v to the new one, times the root of the area's growth g: (n + c) / sqrt(g) - n, with
/// n + c = (u + D u) x (v + D v). Of c alone, so where nothing changes it is 0 to the last digit.
Eigen::Matrix3f change_of_normal(const Eigen::Vector3f& u, const Eigen::Vector3f& v, const Eigen::Matrix3f& D) {
  const Eigen::Vector3f n = u.cross(v);
  const Eigen::Vector3f du = D * u;
  const Eigen::Vector3f dv = D * v;
  const Eigen::Vector3f c = u.cross(dv) + du.cross(v) + du.cross(dv);
  constexpr float kLeast = 1e-24F;
  const float squared_growth = std::max(1 + (2 * n + c).dot(c), kLeast);
  const float per_root = 1 / std::sqrt(std::sqrt(squared_growth));
  return (per_root * c + (per_root - 1) * n) * n.transpose();
}

}  // namespace

AnchorMaps::AnchorMaps(const SurfaceLevels& levels, const std::vector<Node>& anchors, int threads, UsedVertices& used)
    : anchors_(anchors.size()), offsets_(anchors.size() + 1, 0) {
  const auto n = static_cast<int>(anchors.size());
  std::vector<Ring> rings(anchors.size());
  parallel_for(threads, n, [&](int begin, int end) {
    for (int a = begin; a < end; ++a) {
      const SurfaceLevel& level = levels.level(anchors[a].level);
      const int node = anchors[a].node;
      Ring& ring = rings[a];
      ring = Ring(level, node);
      anchors_[a] = {level.vertices[node], level.places.row(node).transpose().cast<float>(),
                     ring.span().u.cast<float>(), ring.span().v.cast<float>(), !ring.span().v.isZero(0)};
      offsets_[a + 1] = static_cast<int>(ring.size());
    }
  });
  make_offsets(offsets_);
  neighbours_.reserve(offsets_.back());
  gradients_.reserve(offsets_.back());
  for (int a = 0; a < n; ++a) {
    anchors_[a].vertex = used.number_of(anchors_[a].vertex);
    const std::vector<int>& vertices = levels.level(anchors[a].level).vertices;
    for (size_t k = 0; k < rings[a].size(); ++k) {
      neighbours_.push_back(used.number_of(vertices[rings[a].node(k)]));
      gradients_.emplace_back();
      gradients_.back() << rings[a].gradient(k).cast<float>(), 0;
    }
  }
}

void AnchorMaps::find_one(int a, const Positions& displacements, float* map) const {
  const Anchor& anchor = anchors_[a];
  const Vector3 here = displacements.row(anchor.vertex).transpose();
  // Rows of four numbers: the length of a vector register.
  Eigen::Vector4f x = Eigen::Vector4f::Zero();
  Eigen::Vector4f y = Eigen::Vector4f::Zero();
  Eigen::Vector4f z = Eigen::Vector4f::Zero();
  for (int k = offsets_[a]; k < offsets_[a + 1]; ++k) {
    const double* next = displacements.data() + 3 * static_cast<size_t>(neighbours_[k]);
    const Eigen::Vector4f& gradient = gradients_[k];
    x += static_cast<float>(next[0] - here[0]) * gradient;
    y += static_cast<float>(next[1] - here[1]) * gradient;
    z += static_cast<float>(next[2] - here[2]) * gradient;
  }
  Eigen::Matrix3f D;
  D << x.head<3>().transpose(), y.head<3>().transpose(), z.head<3>().transpose();
  constexpr float kLargest = 1e8F;  // fourth powers of it are numbers
  D = D.cwiseMax(-kLargest).cwiseMin(kLargest);
  if (anchor.has_plane)
    D += change_of_normal(anchor.u, anchor.v, D);
  else if (!anchor.u.isZero(0))
    D = turn_of_line(anchor.u.cast<double>(), (D * anchor.u).cast<double>()).cast<float>();
  Eigen::Matrix<float, 3, 4, Eigen::RowMajor> all;
  all << D, here.cast<float>() - D * anchor.place;
  Eigen::Matrix<float, 3, 4, Eigen::RowMajor>::Map(map) = all;
}

void AnchorMaps::find(const Positions& displacements, const Workers& workers, AlignedBuffer<float>& maps) const {
  parallel_for(workers, size(), [&](int begin, int end) {
    for (int a = begin; a < end; ++a) find_one(a, displacements, maps.data() + static_cast<size_t>(a) * kNumbers);
  });
}

}  // namespace arap
