// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/anchor_maps.h"

#include <algorithm>
#include <cmath>

#include "base/offsets.h"
#include "dense/small_matrices.h"
#include "geometry/rotation.h"
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
  const auto [values, vectors] = symmetric_eigen(sum);
  if (!(values[2] > 0)) return span;
  span.u = vectors.col(2);
  span.inverse = span.u * span.u.transpose() / values[2];
  if (!(values[1] >= kLeastAcross * values[2])) return span;
  span.v = vectors.col(1);
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
        for (const int other : level.around(nodes_[k])) {
          // The first neighbours are all new, and may be very many.
          const bool is_new = step == 0 || std::find(nodes_.begin(), nodes_.end(), other) == nodes_.end();
          if (is_new && is_apart(level, other)) nodes_.push_back(other);
        }
      begin = end;
      if (nodes_.size() > end) measure(level);
    }
  }

  [[nodiscard]] const Span& span() const { return span_; }
  [[nodiscard]] size_t size() const { return directions_.size(); }
  [[nodiscard]] int node(size_t k) const { return nodes_[k + 1]; }
  [[nodiscard]] Vector3 gradient(size_t k) const { return span_.inverse * directions_[k] / lengths_[k]; }

 private:
  /// There is one node at a place; but on a surface that is next to nothing, squares of distances are nothing.
  [[nodiscard]] bool is_apart(const SurfaceLevel& level, int node) const {
    return (level.places.row(node) - level.places.row(nodes_[0])).squaredNorm() > 0;
  }

  void measure(const SurfaceLevel& level) {
    directions_.clear();
    lengths_.clear();
    for (size_t k = 1; k < nodes_.size(); ++k) {
      const Vector3 edge = (level.places.row(nodes_[k]) - level.places.row(nodes_[0])).transpose();
      lengths_.push_back(edge.norm());
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
  return growth * rotation_between(u, moved) - Matrix3::Identity();
}

void set_frame(std::vector<float>& frames, size_t anchor, const Span& span, const Vector3& place) {
  float* block = frames.data() + anchor / kWrapBlock * 9 * kWrapBlock + anchor % kWrapBlock;
  const bool has_plane = !span.v.isZero(0);
  for (size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    block[i * kWrapBlock] = has_plane ? static_cast<float>(span.u[row]) : 0;
    block[(3 + i) * kWrapBlock] = static_cast<float>(span.v[row]);
    block[(6 + i) * kWrapBlock] = static_cast<float>(place[row]);
  }
}

}  // namespace

AnchorMaps::AnchorMaps(const SurfaceLevels& levels, const std::vector<Node>& anchors, int threads, UsedVertices& used) {
  const auto n = static_cast<int>(anchors.size());
  const size_t n_blocks = (anchors.size() + kWrapBlock - 1) / kWrapBlock;
  vertices_.assign(n_blocks * kWrapBlock, 0);
  offsets_.assign(vertices_.size() + 1, 0);
  frames_.assign(n_blocks * 9 * kWrapBlock, 0);
  std::vector<Ring> rings(anchors.size());
  parallel_for(threads, n, [&](int begin, int end) {
    for (int a = begin; a < end; ++a) {
      const SurfaceLevel& level = levels.level(anchors[a].level);
      rings[a] = Ring(level, anchors[a].node);
      set_frame(frames_, a, rings[a].span(), level.places.row(anchors[a].node).transpose());
      offsets_[a + 1] = static_cast<int>(rings[a].size());
    }
  });
  make_offsets(offsets_);
  neighbours_.reserve(offsets_.back());
  gradients_.reserve(4 * static_cast<size_t>(offsets_.back()));
  for (int a = 0; a < n; ++a) {
    const SurfaceLevel& level = levels.level(anchors[a].level);
    vertices_[a] = used.number_of(level.vertices[anchors[a].node]);
    for (size_t k = 0; k < rings[a].size(); ++k) {
      neighbours_.push_back(used.number_of(level.vertices[rings[a].node(k)]));
      const Vector3 gradient = rings[a].gradient(k);
      for (const double number : gradient) gradients_.push_back(static_cast<float>(number));
      gradients_.push_back(0);
    }
    const Span& span = rings[a].span();
    if (span.v.isZero(0) && !span.u.isZero(0))
      lines_.push_back({a, span.u, level.places.row(anchors[a].node).transpose()});
  }
}

AnchorsView AnchorMaps::view() const {
  return {vertices_.data(), offsets_.data(), neighbours_.data(), gradients_.data(), frames_.data()};
}

void AnchorMaps::turn_line(const OnLine& line, const AlignedBuffer<double>& displacements, float* map) const {
  Eigen::Map<Eigen::Matrix<float, 3, 4, Eigen::RowMajor>> rows(map);
  const Matrix3 D = turn_of_line(line.u, rows.leftCols<3>().cast<double>() * line.u);
  const Vector3 here = Vector3::Map(&displacements[4 * static_cast<size_t>(vertices_[line.anchor])]);
  rows << D.cast<float>(), (here - D * line.place).cast<float>();
}

void AnchorMaps::find(const WrapKernels& kernels, const AlignedBuffer<double>& displacements, const Workers& workers,
                      AlignedBuffer<float>& maps) const {
  constexpr int kBlocks = 32;
  const AnchorsView anchors = view();
  parallel_for<kBlocks>(workers, static_cast<int>(vertices_.size() / kWrapBlock), [&](int begin, int end) {
    kernels.find_maps(anchors, displacements.data(), maps.data(), begin, end);
  });
  for (const OnLine& line : lines_)
    turn_line(line, displacements, maps.data() + static_cast<size_t>(line.anchor) * kMapNumbers);
}

}  // namespace arap
