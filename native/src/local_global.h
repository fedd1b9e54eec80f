// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/options.h"
#include "bound_constraints.h"

namespace arap {

/// Everything an iteration changes.
struct Pose {
  Positions positions;                ///< (n, 3)
  Rotations rotations;                ///< of each cell
  std::vector<Placement> placements;  ///< of each rigid region
};

struct IterationReport {
  double energy_before = 0;
  double energy_after = 0;
  int iterations = 0;
  double step = 0;
  StopReason stop_reason = StopReason::kMaxIterations;
};

/// Alternates the local step (best rotations for the positions) and the global step (best positions for the rotations);
/// neither raises the energy. [SA07] Sec. 2.
class LocalGlobal {
 public:
  /// @param targets  (n_entries + n_patches, 3) in model space
  LocalGlobal(const BoundModel& model, const BoundConstraints& constraints, const Positions& targets);

  /// Puts hard vertices, anchored regions and what stays at rest to their places; true where that moved any of them.
  bool impose_constraints(Pose& pose) const;

  /// The smallest change (in the norm of K) that brings the patches to their targets.
  void project_on_patches(Pose& pose);

  /// One global step with the rotations of the pose.
  void global_step(Pose& pose);

  IterationReport run(Pose& pose, const SolveOptions& options, const Progress& progress);

 private:
  /// Local step; then the energy, and the residual for the next global step.
  [[nodiscard]] double fit(Pose& pose);
  [[nodiscard]] double refresh_residual(const Pose& pose);
  [[nodiscard]] Positions patch_gaps(const Positions& positions) const;
  /// The global step from the residual at hand: what brings patches closer by `gaps`.
  void find_correction(const Positions& gaps, Positions& correction);
  /// The whole step at once, to the accuracy of double.
  void apply_residual_exactly(Pose& pose);

  /// The state of the conjugate gradients between two iterations.
  struct Search {
    bool is_fresh = true;  ///< the next step is a plain global step
    double length = 1;     ///< of the last step
    double z_r = 0;        ///< <correction, residual> of the last iteration
    Positions start;       ///< positions before the last step
    Positions residual;    ///< there
    Positions correction;  ///< the plain global step from there
    Positions direction;
    std::vector<Placement> placements;  ///< before the last step
  };
  /// Steps from search.start by `length` along search.direction and fits the rotations there; returns the energy.
  [[nodiscard]] double try_step(Pose& pose, double length, const Search& search);
  /// One iteration; returns the energy, which is not above `energy`, that of the pose.
  [[nodiscard]] double iterate(Pose& pose, double energy, Search& search);

  const BoundModel& model_;
  const BoundConstraints& constraints_;
  RegionTargets targets_;  ///< of vertices, and of patches that anchor regions
  Positions patch_targets_;
  Positions residual_;
  Positions multipliers_;
};

}  // namespace arap
