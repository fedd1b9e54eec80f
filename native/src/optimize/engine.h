// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "arap/options.h"
#include "constraints/handle_rotations.h"
#include "constraints/prepared_constraints.h"
#include "optimize/drag_predictor.h"
#include "optimize/local_global.h"
#include "optimize/nonlinear_cg.h"

namespace arap {

/// Poses a prepared model: prepare() factorizes, solve() iterates to targets. It knows no mesh; all positions
/// are in the model's space and numbering. A model (SurfaceArap is one) is an assembler, which fills in the
/// PreparedModel, and a face, which maps its user's constraints and positions to the model's and back.
class Engine {
 public:
  /// Takes the positions of a solve; false if one of them is not finite.
  using HandOver = std::function<bool(const Positions& positions)>;

  /// @param model  whole; must outlive the engine
  explicit Engine(const PreparedModel& model);

  /// A set of constraints for this model, to take() once nothing can fail any more.
  struct Change {
    std::unique_ptr<PreparedConstraints> constraints;
    std::unique_ptr<HandleRotations> handle_rotations;  ///< refers to them
    Rotations rotations;                                ///< of the pose, in their cells
  };
  /// Throws InvalidInput, SolverError or Cancelled; the former constraints stay.
  [[nodiscard]] Change prepare(const ModelConstraints& given, const Progress& progress);
  void take(Change change) noexcept;
  [[nodiscard]] bool has_constraints() const { return constraints_ != nullptr; }

  /// Moves the pose towards the targets. A solve to the targets of the last one goes on with its search. A cancelled
  /// solve hands over the former pose and changes nothing, but that the next one begins a new search.
  /// @param targets    (n_targets, 3), finite
  /// @param rotations  of each row, or empty: see HandleRotations
  /// Throws SolverError if positions are no longer finite. After an exception the pose is the former one.
  IterationReport solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                        const Progress& progress, const HandOver& hand_over);

  [[nodiscard]] const Positions& positions() const { return pose_.positions; }
  /// The pose that has these positions, with the rotations that fit them best.
  [[nodiscard]] Pose fitted(Positions positions);
  [[nodiscard]] Pose at_rest() const;
  /// Starts the next solve from here; the constraints stay.
  void take(Pose pose) noexcept;
  /// Goes back to the pose before the last solve, which was not cancelled, or the last take().
  void undo() noexcept;

  /// The energy at `positions` with the best rotations, without constraint terms, and its gradient, (n, 3). Cells are
  /// those of the constraints. Rigid regions have the rotation that their vertices have made, by least squares.
  double evaluate(const Positions& positions, Positions& gradient);

  /// Components of the input without any constraint.
  [[nodiscard]] const std::vector<int>& parts_at_rest() const { return constraints_->parts_at_rest; }
  /// Numeric factorizations so far.
  [[nodiscard]] int n_factorizations() const { return n_factorizations_; }

 private:
  /// How a solve starts, from its targets and those of the last one.
  struct Start {
    Positions rotations;         ///< rotation vectors of the targets' rows; no rows: nothing rotates
    Positions step;              ///< from the last targets; no rows: unknown
    double ahead = 0;            ///< how far the forces start ahead, see DragPredictor
    bool goes_on = false;        ///< from the pose of the last solve
    bool goes_on_there = false;  ///< to the same targets

    [[nodiscard]] bool is_drag() const { return rotations.rows() == 0 && (step.array() != 0).any(); }
  };

  [[nodiscard]] int n_cells() const {
    return model_.energy.n_cells(has_constraints() ? constraints_->cells(model_) : model_.energy.cells);
  }
  [[nodiscard]] CellPasses& passes(Precision precision) const {
    return has_constraints() ? constraints_->passes(model_, precision) : model_.passes(precision);
  }
  /// The rotations of the pose, in the cells of others.
  [[nodiscard]] Rotations rotations_for(const PreparedConstraints& constraints) const;
  /// Then nothing is predicted: stresses grow with the fifth power of a torn pose, and from frame to frame.
  [[nodiscard]] bool keeps_volumes() const { return model_.energy.volume_stiffness > 0; }
  [[nodiscard]] Start plan(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations);
  [[nodiscard]] Precision first_precision(const Positions& targets, const SolveOptions& options,
                                          bool goes_on_there) const;
  /// Returns the largest movement of its global step, if that is half of an iteration.
  std::optional<double> apply_guess(const Positions& targets, InitialGuess guess, const Start& start);
  void learn(Positions targets, const Start& start);
  void move_to_rest();
  void end_search() noexcept;
  /// Begins a new search unless there is one.
  void require_search();
  /// Gives the memory of what the next solve makes again to a new factor: the old one stays, in case that the change of
  /// constraints fails.
  void make_room();
  /// What a failing solve goes back to.
  void keep_pose();
  void restore_pose() noexcept;

  const PreparedModel& model_;
  std::unique_ptr<PreparedConstraints> constraints_;
  std::unique_ptr<HandleRotations> handle_rotations_;
  std::unique_ptr<LocalGlobal> steps_;   ///< over constraints_; made by a solve
  std::unique_ptr<NonlinearCg> search_;  ///< over steps_; made with it
  Pose pose_;
  Pose kept_;               ///< the one before
  Positions last_targets_;  ///< of the pose; empty if it comes from somewhere else
  DragPredictor predictor_;
  int n_factorizations_ = 0;
};

}  // namespace arap
