// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/polygon_ears.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <numeric>
#include <tuple>
#include <utility>

namespace arap {

namespace {

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Also on the rim, but not at a corner: there a face may touch itself.
bool is_in(const Point& p, const std::array<Point, 3>& corners) {
  for (int k = 0; k < 3; ++k) {
    if (p == corners[k]) return false;
    if (cross(corners[(k + 1) % 3] - corners[k], p - corners[k]) < 0) return false;
  }
  return true;
}

}  // namespace

bool EarCutter::Ear::operator>(const Ear& other) const {
  return std::tie(length, corner) > std::tie(other.length, other.corner);
}

void EarCutter::flatten(const Positions& points, std::span<const int> face) {
  const Eigen::RowVector3d first = points.row(face[0]);
  Eigen::RowVector3d normal = Eigen::RowVector3d::Zero();
  for (size_t k = 1; k + 1 < face.size(); ++k)
    normal += (points.row(face[k]) - first).cross(points.row(face[k + 1]) - first);
  // Along the axis that it is steepest to: a linear map keeps sides and what is inside.
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + (normal[axis] < 0 ? 2 : 1)) % 3;
  const int v = 3 - axis - u;
  flat_.clear();
  for (const int corner : face) flat_.emplace_back(points(corner, u) - first[u], points(corner, v) - first[v]);
}

double EarCutter::area(int corner) const {
  return cross(flat_[corner] - flat_[before_[corner]], flat_[after_[corner]] - flat_[corner]);
}

bool EarCutter::is_blocked(int corner) const {
  const std::array<Point, 3> corners{flat_[before_[corner]], flat_[corner], flat_[after_[corner]]};
  const auto [least, most] = std::minmax({corners[0][0], corners[1][0], corners[2][0]});
  // If any corner is in there, a reflex one is.
  for (auto k = std::lower_bound(xs_.begin(), xs_.end(), least) - xs_.begin(); k < std::ssize(xs_) && xs_[k] <= most;
       ++k) {
    const int other = by_x_[k];
    if (other == corner || other == before_[corner] || other == after_[corner] || before_[other] < 0) continue;
    if (is_in(flat_[other], corners) && area(other) < 0) return true;
  }
  return false;
}

void EarCutter::offer(int corner) {
  if (area(corner) < 0) return;
  ears_.push_back(
      {(flat_[after_[corner]] - flat_[before_[corner]]).squaredNorm(), corner, before_[corner], after_[corner]});
  std::push_heap(ears_.begin(), ears_.end(), std::greater<>());
}

bool EarCutter::is_current(const Ear& ear) const {
  return before_[ear.corner] == ear.before && after_[ear.corner] == ear.after;
}

int EarCutter::next_ear() {
  while (true) {
    while (!ears_.empty()) {
      std::pop_heap(ears_.begin(), ears_.end(), std::greater<>());
      const Ear ear = ears_.back();
      ears_.pop_back();
      if (!is_current(ear)) continue;
      if (is_blocked(ear.corner)) {
        blocked_.push_back(ear);
        continue;
      }
      has_cut_ = true;
      return ear.corner;
    }
    if (!has_cut_) break;
    has_cut_ = false;
    std::swap(ears_, blocked_);
    std::make_heap(ears_.begin(), ears_.end(), std::greater<>());
  }
  // A face that crosses itself: any corner will do.
  while (before_[first_left_] < 0) ++first_left_;
  return first_left_;
}

void EarCutter::cut(const Positions& points, std::span<const int> face, std::vector<std::array<int, 3>>& triangles) {
  const auto n = static_cast<int>(face.size());
  if (n == 3) {
    triangles.push_back({face[0], face[1], face[2]});
    return;
  }
  flatten(points, face);
  before_.resize(n);
  after_.resize(n);
  for (int k = 0; k < n; ++k) {
    before_[k] = (k + n - 1) % n;
    after_[k] = (k + 1) % n;
  }
  by_x_.resize(n);
  std::iota(by_x_.begin(), by_x_.end(), 0);
  std::sort(by_x_.begin(), by_x_.end(), [&](int a, int b) { return flat_[a][0] < flat_[b][0]; });
  xs_.clear();
  for (const int k : by_x_) xs_.push_back(flat_[k][0]);
  ears_.clear();
  blocked_.clear();
  has_cut_ = false;
  first_left_ = 0;
  for (int k = 0; k < n; ++k) offer(k);
  for (int n_left = n; n_left > 2; --n_left) {
    const int ear = next_ear();
    const int before = before_[ear];
    const int after = after_[ear];
    triangles.push_back({face[before], face[ear], face[after]});
    before_[ear] = -1;
    after_[before] = after;
    before_[after] = before;
    if (n_left == 3) break;
    offer(before);
    offer(after);
  }
}

}  // namespace arap
