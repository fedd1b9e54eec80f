// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "constraints/handle_rotations.h"
#include "constraints/prepared_constraints.h"
#include "models/poisson_editing/handle_weights.h"
#include "models/poisson_editing/poisson_model.h"
#include "sampling/edge_graph.h"

namespace arap {

/// Poses a surface by turns and scales of its handles. All is in the model's space and numbers.
class PoissonSolver {
 public:
  struct Pose {
    Positions positions;  ///< (n, 3)
    Positions turns;      ///< (n, 3) rotation vectors; no rows: at rest
  };

  /// @param model  whole; must outlive the solver
  PoissonSolver(const PoissonModel& model, Propagation propagation) : model_(model), propagation_(propagation) {}

  /// Throws InvalidInput, SolverError or Cancelled, and then the former constraints stay.
  void set_constraints(const ConstraintSet& set, const Progress& progress);
  [[nodiscard]] bool has_constraints() const { return constraints_ != nullptr; }
  [[nodiscard]] const std::vector<int>& parts_at_rest() const { return constraints_->parts_at_rest; }

  /// @param targets     (n_targets, 3)
  /// @param rotations   of each target's handle, times a scale > 0; or empty: estimated
  /// @param last_turns  (n, 3) that turns go on from; no rows: they go the short way
  /// @return  nothing where progress stops it
  [[nodiscard]] std::optional<Pose> solve(const Positions& targets, std::span<const Matrix3> rotations,
                                          const Positions& last_turns, const Progress& progress) const;

 private:
  /// Connected groups of constrained vertices, and patches.
  struct Handles {
    std::vector<int> of_row;  ///< (n_targets,) counted from 0
    int count = 0;
    HandleWeights weights;  ///< none of many harmonic ones: each solve spreads what the rows have
  };

  void find_weights(const ConstraintSet& set, const PreparedConstraints& constraints, const Progress& progress,
                    Handles& handles);
  /// Whether all rows of a handle have the same.
  [[nodiscard]] bool are_alike(const Positions& of_rows) const;
  /// What the targets' rows have, over the surface.
  [[nodiscard]] Positions spread(const Positions& of_rows) const;
  /// The surface that the forces of its faces drive, with the constraints at the targets.
  [[nodiscard]] Positions driven(Positions forces, const Positions& targets) const;

  const PoissonModel& model_;
  Propagation propagation_;
  std::unique_ptr<EdgeGraph> graph_;  ///< made when first needed
  std::unique_ptr<PreparedConstraints> constraints_;
  std::unique_ptr<HandleRotations> handle_rotations_;  ///< refers to constraints_
  Handles handles_;
};

}  // namespace arap
