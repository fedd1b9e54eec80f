// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "arap/options.h"
#include "cholesky/linear_solver.h"
#include "constraints/rigid_regions.h"
#include "energy/cell_energy.h"
#include "energy/cell_passes.h"
#include "energy/split_cells.h"

namespace arap {

struct PreparedModel;

/// The passes over some cells of a model, each made when first needed. Those of a large one are valid until the others
/// are asked for: these then take their memory.
class KeptPasses {
 public:
  /// In double if single precision does not serve the energy.
  /// @param cells  always the same; must outlive this
  [[nodiscard]] CellPasses& of(const PreparedModel& model, const Cells& cells, Precision precision);
  /// Whoever needs passes asks for them again.
  void drop() noexcept;

 private:
  std::unique_ptr<CellPasses> single_;
  std::unique_ptr<CellPasses> double_;
};

/// What an assembler makes of its input, and all that constraints and iterations know of it: an energy in the one form
/// of CellEnergy, the rest positions of its unknowns, and a solver for the pattern of its matrix. The unknowns are
/// called vertices here; they may be the vertices of a surface, those of tetrahedra or the control points of a lattice.
///
/// An assembler fills in energy, rest, parts, workers and regions, calls make_solver() when K is whole, and
/// take_solver_numbers() or keep_numbers() when the cells are.
struct PreparedModel {
  CellEnergy energy;
  Positions rest;                   ///< (n, 3), centred, of size 1: tolerances are parts of it
  std::vector<int> part_of_vertex;  ///< (n,) connected component of the input, -1 = isolated vertex
  int n_parts = 0;
  Workers workers;                                ///< of the bind and of iterations
  const SolverFactory* solver_factory = nullptr;  ///< see Options
  bool fits_single = false;                       ///< whether single precision serves this energy
  RigidRegions regions;                           ///< without constraints
  std::vector<int> components;                    ///< (n,) connected_components() of system_matrix()
  std::unique_ptr<LinearSolver> solver;           ///< for its pattern
  std::unique_ptr<const CellTerms> terms;  ///< what cells are split by; null: where held vertices cut, cells end, too

  PreparedModel() : regions({}, energy, rest) {}
  PreparedModel(const PreparedModel&) = delete;  // regions refers to energy and rest
  PreparedModel& operator=(const PreparedModel&) = delete;

  /// K over the unknowns of the regions.
  [[nodiscard]] const SparseMatrix& system_matrix() const { return regions.empty() ? energy.K : reduced_matrix_; }

  /// A solver for the pattern of the present K and regions. The caller stores it in `solver`: it may be made beside
  /// other work.
  [[nodiscard]] std::unique_ptr<LinearSolver> make_solver(const MeterPart& meter = {});

  /// Lets single precision serve if the energy is such that it can, and large enough for it to be faster.
  void choose_precision();

  /// For an energy and rest positions whose vertices have the solver's numbers already: regions, parts and the solver
  /// take them too. Where the solver has no numbers of its own, all keep theirs. Returns the new number of each vertex.
  std::vector<int> take_solver_numbers(const MeterPart& meter = {});
  /// For an energy whose vertices keep their numbers.
  void keep_numbers();

  /// Over `energy`.
  [[nodiscard]] CellPasses& passes(Precision precision) const {
    return kept_passes_.of(*this, energy.cells, precision);
  }

  /// Whether memory decides what stays.
  [[nodiscard]] bool is_large() const { return energy.is_large(); }
  void drop_passes() const noexcept { kept_passes_.drop(); }

 private:
  SparseMatrix reduced_matrix_;  ///< empty without regions
  mutable KeptPasses kept_passes_;
};

}  // namespace arap
