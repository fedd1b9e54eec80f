// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "arap/types.h"
#include "parallel/meter.h"

namespace arap {

/// Points in rows along all three axes.
struct SampleBox {
  Eigen::RowVector3d first = Eigen::RowVector3d::Zero();
  double spacing = 1;
  std::array<int, 3> counts{};

  [[nodiscard]] Eigen::RowVector3d place(const std::array<int, 3>& sample) const {
    return first + spacing * Eigen::RowVector3d(sample[0], sample[1], sample[2]);
  }
};

/// A line of samples passes through a triangle.
struct Crossing {
  std::array<int, 2> line;  ///< the sample's numbers along the two axes after the line's
  int before;               ///< the last sample before the triangle; -1: there is none
  int sign;                 ///< 1 if the line leaves through the triangle's front, -1 if it enters
  int triangle;
  double place;  ///< along the axis
};

/// Where the lines of samples along an axis pass through triangles, line by line, each in order. Through a closed
/// surface a line passes as often outwards as inwards, also where it meets edges and vertices [Edelsbrunner, Mücke
/// 1990, "Simulation of simplicity": lines are moved by an infinitely small amount].
[[nodiscard]] std::vector<Crossing> find_crossings(const Positions& points,
                                                   const std::vector<std::array<int, 3>>& triangles,
                                                   const SampleBox& samples, int axis, const MeterPart& meter = {});

}  // namespace arap
