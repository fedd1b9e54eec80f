// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cell_energy.h"

#include <utility>

#include "base/permutation.h"

namespace arap {

void take_cells(CellEnergy& energy, Cells::Rows rows, const std::vector<int>& homes, const std::vector<int>* order,
                int threads, const MeterPart& meter) {
  const std::vector<int> new_of_old = order == nullptr ? std::vector<int>() : inverse_permutation(*order);
  energy.cells = Cells(std::move(rows), homes, new_of_old, meter);
  if (order != nullptr) energy.K = renumbered(energy.K, *order, new_of_old, threads);
}

void take_cubes(CellEnergy& energy, CubeCells cubes, const std::vector<int>* order, int threads) {
  energy.cubes = std::move(cubes);
  if (order == nullptr) return;
  const std::vector<int> new_of_old = inverse_permutation(*order);
  energy.cubes.renumber(new_of_old);
  energy.K = renumbered(energy.K, *order, new_of_old, threads);
}

}  // namespace arap
