// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>
#include <vector>

#include "arap/types.h"

namespace arap {

/// Triangles that a face is made of, also if it is concave: none is outside, unless the face crosses itself. Ear
/// clipping [Meisters 1975], the shortest cut first, so mirrored faces are cut alike. All have the face's side as their
/// front, and there are as many as corners but two.
class EarCutter {
 public:
  /// Adds the triangles.
  /// @param points  (n, 3)
  /// @param face    its corners, at least three
  void cut(const Positions& points, std::span<const int> face, std::vector<std::array<int, 3>>& triangles);

 private:
  using Point = Eigen::Vector2d;

  /// A corner that may be cut off, and how long the cut is, squared.
  struct Ear {
    double length;
    int corner;
    int before;
    int after;
    bool operator>(const Ear& other) const;
  };

  void flatten(const Positions& points, std::span<const int> face);
  /// Twice the area that is cut off at a corner; negative at a reflex one.
  [[nodiscard]] double area(int corner) const;
  /// Whether another corner is in the triangle at this one.
  [[nodiscard]] bool is_blocked(int corner) const;
  void offer(int corner);
  /// A corner to be cut off.
  int next_ear();
  [[nodiscard]] bool is_current(const Ear& ear) const;

  std::vector<Point> flat_;
  std::vector<int> before_;  ///< of each corner that is left; -1: it is cut off
  std::vector<int> after_;
  std::vector<int> by_x_;     ///< corners
  std::vector<double> xs_;    ///< of by_x_
  std::vector<Ear> ears_;     ///< heap of convex corners
  std::vector<Ear> blocked_;  ///< those that others were in
  bool has_cut_ = false;      ///< since the blocked ones were tried
  int first_left_ = 0;        ///< none before this corner is left
};

}  // namespace arap
