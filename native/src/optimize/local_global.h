// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "constraints/prepared_constraints.h"
#include "optimize/drag_predictor.h"

namespace arap {

/// Everything an iteration changes.
struct Pose {
  Positions positions;                ///< (n, 3)
  Rotations rotations;                ///< of each cell
  std::vector<Placement> placements;  ///< of each rigid region
};

/// A rotation of each unknown.
using RotationAt = std::function<Eigen::Quaterniond(int unknown)>;

/// Turns all cells, and the regions that nothing anchors, by the rotations of their unknowns; the regions' members
/// move along.
void turn_cells(const PreparedModel& model, const PreparedConstraints& constraints, const RotationAt& rotation_at,
                Pose& pose);

/// The largest length of a row.
[[nodiscard]] double longest_row(const Positions& x, const Workers& workers);

/// The two halves of an iteration: the local step (best rotations for the positions) and the global step (best
/// positions for the rotations); neither raises the energy, unless it keeps volumes. [SA07] Sec. 2.
class LocalGlobal {
 public:
  LocalGlobal(const PreparedModel& model, const PreparedConstraints& constraints);

  /// Call it before the first step and whenever targets change. It reuses the residual if the pose is the one that
  /// finish() left.
  /// @param targets  (n_targets, 3) in model space
  void set_targets(const Positions& targets, Precision precision);

  /// (n, 3), 0 where there is none.
  [[nodiscard]] const Positions& vertex_targets() const { return targets_.vertices; }

  /// Puts hard vertices, anchored regions and what stays at rest to their places; true if that moved any of them.
  bool impose_constraints(Pose& pose);

  /// The smallest change (in the norm of about K) that brings patches and stiff rows to their targets.
  void project_on_held(Pose& pose);

  /// One global step with the rotations of the pose, to the accuracy of the factor or to a part of itself. Returns the
  /// largest movement of a vertex.
  double global_step(Pose& pose);
  /// The same with forces ahead of the pose.
  double global_step(Pose& pose, const DragPredictor& prediction, double share);
  void global_step_to(double accuracy, Pose& pose);

  /// What turned cells make of a global step.
  struct Response {
    Positions force;  ///< (n, 3): the change of the residual
    Positions step;   ///< (n, 3): that of the global step, in which constraints stay met
  };
  /// The residual and the passes are those of the turned pose afterwards.
  /// @param pose      with the rotations of its cells
  /// @param residual  of the pose
  [[nodiscard]] Response respond(const Pose& pose, const Positions& residual, const RotationAt& rotation_at);

  /// Starts from the rotations of the pose; fit() leaves those it finds in the passes until finish().
  void start(const Pose& pose);
  void finish(Pose& pose);
  /// The next fit() is in double, from the rotations of the last one; false if it has been so already.
  [[nodiscard]] bool go_on_in_double(Pose& pose);
  [[nodiscard]] bool is_in_double() const { return is_in_double_; }
  /// Call it if anybody else changes the pose or works with the passes.
  void forget() noexcept { known_ = Known::kNothing; }
  /// Call it if the pose is replaced by another one: what held the rows of the former pose is no start for it.
  void forget_pose() noexcept {
    forget();
    multipliers_.resize(0, 3);
  }
  /// Whether the pose is the one that finish() left.
  [[nodiscard]] bool knows_pose() const { return known_ != Known::kNothing; }

  /// Local step. Returns the energy, and leaves the residual for the next global step.
  [[nodiscard]] double fit(Pose& pose);

  /// A step begins at this pose: global_step() says so itself.
  void begin_step(const Pose& pose);
  /// The largest movement of a vertex since then: with the regions that fit() has turned.
  /// @param step  the largest one by the step itself
  [[nodiscard]] double step_with_turns(const Pose& pose, double step) const;

  /// After the first fit of a frame, which began with this share of the forces ahead.
  void show_forces_to(DragPredictor& prediction, double share);

  /// Whether fit() leaves the positions of unknowns: patches that are partly in regions move them with the regions'
  /// turns, which no direction says.
  [[nodiscard]] bool fit_keeps_unknowns() const { return constraints_.mixed_patches.empty(); }
  /// b - K p and the forces of soft constraints, where fit() has left it.
  [[nodiscard]] const Positions& residual() const { return residual_; }
  /// As fit() has left them.
  void read_rotations(Rotations& rotations) const { passes_->read_rotations(rotations); }
  [[nodiscard]] const Positions& rest() const { return model_.rest; }

  /// use(residual), with minus the gradient of the energy, soft and stiff constraints included, but for what holds the
  /// patches, (n, 3): no direction has a share in that, but its rounding would drown the slopes near the minimum. If it
  /// throws, the residual is lost: forget_pose().
  template <class Use>
  auto with_free_residual(const Use& use) {
    add_free_forces(1);
    const auto result = use(std::as_const(residual_));
    add_free_forces(-1);
    return result;
  }
  /// The whole global step from the residual at hand, (n, 3); `correction` may be the residual.
  void find_correction(const Pose& pose, Positions& correction);
  /// Tells the regions that their vertices were moved alike.
  void follow_positions(Pose& pose) const { constraints_.regions.read_translations(pose.placements, pose.positions); }

  /// Smallest change of `energy` that is not rounding.
  [[nodiscard]] double energy_rounding(double energy) const { return passes_->energy_rounding(energy); }
  /// A movement of a vertex that is no more than rounding of its place.
  [[nodiscard]] double movement_rounding() const { return 4 * std::numeric_limits<double>::epsilon() * reach_; }
  [[nodiscard]] const Workers& workers() const { return model_.workers; }

 private:
  /// What is at hand of the pose, besides itself.
  enum class Known {
    kNothing,
    kRotations,  ///< in the passes
    kResidual,   ///< and in residual_
  };

  /// Hands the rotations of the pose to the passes, if they have not got them.
  void know_rotations(const Pose& pose);
  /// Brings rigid regions to their best rotations, after the cells. Returns the sum of <R_c, Q_c>.
  [[nodiscard]] double fit_regions(Pose& pose);
  /// The energy without its term of rotations.
  [[nodiscard]] double refresh_residual(const Pose& pose);
  /// The rows of the vertices that fit() moves: members of regions, with mixed patches all.
  void read_turned(const Positions& positions, Positions& rows) const;
  /// Adds what the last multipliers hold patches and stiff rows with to the residual, times `sign`.
  void add_held_forces(double sign);
  /// What the residual lacks of the energy's slope, times `sign`: less what holds the patches, and the stiff rows'
  /// pull.
  void add_free_forces(double sign);
  [[nodiscard]] Positions held_gaps(const Positions& positions) const;
  [[nodiscard]] Positions mixed_gaps(const Positions& positions) const;
  /// The forces of soft rows in `gaps`, (n_rows, 3), are added to the residual; returns their energy.
  double add_row_forces(const Positions& gaps);
  /// For the positions and rotations of the pose, whatever the passes have been about.
  void find_residual_of(const Pose& pose);
  /// The same by what changes if one vertex is moved.
  void follow_vertex(int v, const Eigen::RowVector3d& step);
  /// The whole step at once, as global_step(); or to a part of itself.
  double apply_residual(Pose& pose);
  void apply_residual_to(double accuracy, Pose& pose);
  /// The residual has become a correction of the unknowns.
  void add_correction(Pose& pose);

  const PreparedModel& model_;
  const PreparedConstraints& constraints_;
  CellPasses* passes_ = nullptr;
  bool is_in_double_ = false;
  double reach_ = 1;  ///< largest coordinate of the mesh and its targets
  Known known_ = Known::kNothing;
  RegionTargets targets_;  ///< of vertices, of patches that anchor regions, and of soft rows
  Positions held_targets_;
  Positions residual_;    ///< b - K p plus soft constraints
  Positions stiff_gaps_;  ///< of stiff rows, where the residual is
  Positions multipliers_;
  Positions start_;  ///< of the last step: of all vertices that fit() moves
};

}  // namespace arap
