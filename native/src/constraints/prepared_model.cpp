// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/prepared_model.h"

#include <future>
#include <numeric>

#include "base/eigen_compat.h"
#include "base/permutation.h"
#include "cholesky/solver_choice.h"
#include "parallel/parallel.h"
#include "sparse/sparse.h"

namespace arap {

std::unique_ptr<LinearSolver> PreparedModel::make_solver(const MeterPart& meter) {
  if (!regions.empty()) reduced_matrix_ = regions.reduce(energy.K);
  return make_linear_solver(system_matrix(), workers, TileFormat::kHalf, meter, solver_factory);
}

void PreparedModel::choose_precision() {
  // In a sum over few cells single precision shows, and there is no time to win.
  constexpr int kFewVertices = 2000;
  fits_single = energy.n_vertices() >= kFewVertices && fits_single_precision(energy, rest);
}

std::vector<int> PreparedModel::take_solver_numbers(const MeterPart& meter) {
  if (solver->ordering() == nullptr) {
    keep_numbers();
    std::vector<int> unchanged(rest.rows());
    std::iota(unchanged.begin(), unchanged.end(), 0);
    return unchanged;
  }
  const std::vector<int> order = *solver->ordering();
  std::vector<int> new_of_old = inverse_permutation(order);
  regions.renumber(new_of_old);
  if (!regions.empty()) reduced_matrix_ = regions.reduce(energy.K);
  std::future<void> renumbered = beside(workers, [&] { solver->renumber(system_matrix()); });
  components = connected_components(system_matrix());
  meter.tell();
  rest = Positions(rest(order, all));
  part_of_vertex = permuted(part_of_vertex, order);
  regions.read_cells(energy.cells);
  meter.wait_for(renumbered);
  renumbered.get();
  return new_of_old;
}

void PreparedModel::keep_numbers() {
  components = connected_components(system_matrix());
  regions.read_cells(energy.cells);
}

CellPasses& KeptPasses::of(const PreparedModel& model, const Cells& cells, Precision precision) {
  const Precision served = model.fits_single ? precision : Precision::kDouble;
  auto& made = served == Precision::kSingle ? single_ : double_;
  if (model.is_large()) (served == Precision::kSingle ? double_ : single_) = nullptr;
  if (made == nullptr) made = make_cell_passes(model.energy, cells, model.rest, served, model.workers);
  return *made;
}

void KeptPasses::drop() noexcept {
  single_ = nullptr;
  double_ = nullptr;
}

}  // namespace arap
