// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cube_cells.h"

#include <cstddef>
#include <utility>

#include "base/offsets.h"
#include "energy/sliced_rows.h"

namespace arap {

CubeCells::CubeCells(int n_cells, std::vector<ControlPoints> control_points, std::vector<double> weights)
    : n_cells_(n_cells), control_points_(std::move(control_points)), weights_(std::move(weights)) {
  find_slots();
}

void CubeCells::find_slots() {
  offsets_.assign(whole_slices(n_cells_) + 1, 0);
  for (const ControlPoints& of_cube : control_points_)
    for (const int c : of_cube) ++offsets_[c + 1];
  make_offsets(offsets_);
  slots_.resize(offsets_.back());
  std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
  for (int cube = 0; cube < n_cubes(); ++cube)
    for (int k = 0; k < kControlPoints; ++k) slots_[next[control_points_[cube][k]]++] = kCubeSlots * cube + k;
}

void CubeCells::renumber(const std::vector<int>& new_of_old) {
  for (ControlPoints& of_cube : control_points_)
    for (int& c : of_cube) c = new_of_old[c];
  find_slots();
}

std::vector<double> CubeCells::traces(double cube_size) const {
  constexpr double kSmooth[] = {1.0 / 6, 2.0 / 3, 1.0 / 6};
  std::vector<double> result(n_cells_, 0);
  for (int cube = 0; cube < n_cubes(); ++cube)
    for (int k = 0; k < kControlPoints; ++k)
      result[control_points_[cube][k]] +=
          kSmooth[k / 9] * kSmooth[k / 3 % 3] * kSmooth[k % 3] * weights_[cube] * cube_size;
  return result;
}

}  // namespace arap
