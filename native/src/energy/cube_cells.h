// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "kernels/cell_kernels.h"

namespace arap {

/// Cells over cubes of 27 control points each, for an energy whose unknowns these are. A cell c is at control point c
/// and has of each cube e around it the share w_ec = (1/6, 2/3, 1/6)^3:
///
///     Q_c = sum_e w_ec Q_e,   q_cj = sum_e w_ec weight_e gamma_ej,
///
/// Q_e = weight_e times the cube's size times its mean deformation gradient, gamma_ej the mean gradient of the linear
/// weights of control point j in a cube of size 1. An iteration goes through the cubes: their lists are a twentieth of
/// those of all q_cj.
class CubeCells {
 public:
  using ControlPoints = std::array<int, kControlPoints>;

  CubeCells() = default;
  /// @param weights  of each cube
  CubeCells(int n_cells, std::vector<ControlPoints> control_points, std::vector<double> weights);

  [[nodiscard]] bool empty() const { return control_points_.empty(); }
  /// Cells, as many as control points.
  [[nodiscard]] int size() const { return n_cells_; }
  [[nodiscard]] int n_cubes() const { return static_cast<int>(control_points_.size()); }
  [[nodiscard]] const ControlPoints& control_points(int cube) const { return control_points_[cube]; }
  [[nodiscard]] const std::vector<double>& weights() const { return weights_; }
  /// As CubeView has them.
  [[nodiscard]] const std::vector<int>& offsets() const { return offsets_; }
  [[nodiscard]] const std::vector<int>& slots() const { return slots_; }

  /// Numbers the control points, and so the cells, anew.
  void renumber(const std::vector<int>& new_of_old);

  /// (n_cells,) tr(Q_c) / 3 where cubes have this size and are at rest.
  [[nodiscard]] std::vector<double> traces(double cube_size) const;

 private:
  void find_slots();

  int n_cells_ = 0;
  std::vector<ControlPoints> control_points_;  ///< of each cube
  std::vector<double> weights_;
  std::vector<int> offsets_;
  std::vector<int> slots_;
};

}  // namespace arap
