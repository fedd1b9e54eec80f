// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "arap/constraints.h"
#include "base/eigen_compat.h"
#include "constraints/constrained_system.h"
#include "constraints/mixed_patches.h"
#include "constraints/prepared_model.h"
#include "constraints/rigid_regions.h"

namespace arap {

/// A set of constraints, prepared for a model: entries on the same vertex are merged, each unknown is fixed or free,
/// and the system is factorized. Nothing changes later but the second system, which a naive Laplacian guess makes.
class PreparedConstraints {
 public:
  /// @param set  of vertices of the model; a vertex may have several entries
  /// Throws InvalidInput, SolverError or Cancelled.
  PreparedConstraints(const PreparedModel& model, const ConstraintSet& set, const Progress& progress);

  /// Writes the rows of constrained vertices. A vertex with several entries takes their mean, weighted by strength.
  /// @param targets    (n_entries + n_patches, 3) on the model
  /// @param of_vertex  (n, 3)
  void write_vertex_targets(const Positions& targets, Positions& of_vertex) const;
  /// The rows of patches(), and of the patches that anchor regions.
  [[nodiscard]] Positions patch_targets(const Positions& targets) const { return targets(patch_rows_, all); }
  [[nodiscard]] Positions anchor_targets(const Positions& targets) const { return targets(anchor_rows_, all); }

  /// (n_entries + n_patches, 3): where what is constrained is.
  [[nodiscard]] Positions constrained_points(const Positions& positions) const;

  [[nodiscard]] const RigidRegions& regions() const { return regions_; }
  [[nodiscard]] const ConstrainedSystem& system() const { return *system_; }

  /// min |K x - K rest|^2 under the same constraints; made on the first call.
  [[nodiscard]] const ConstrainedSystem& laplacian_system(const PreparedModel& model);
  [[nodiscard]] bool has_laplacian_system() const { return laplacian_system_ != nullptr; }

  /// (n,) vertices that sit exactly at their target.
  [[nodiscard]] const std::vector<char>& is_hard() const { return is_hard_; }
  /// (n,) vertices that stay at rest: loose ones and those of components without constraint.
  [[nodiscard]] const std::vector<char>& is_at_rest() const { return is_at_rest_; }
  /// (n,) 2 omega of soft vertices, 0 elsewhere; omega_i = K_ii s / (1 - s).
  [[nodiscard]] const Eigen::VectorXd& soft_diagonal() const { return soft_diagonal_; }
  [[nodiscard]] const std::vector<int>& hard_vertices() const { return hard_vertices_; }
  /// Whether a part is held by nothing but soft constraints so weak that rounded forces in it could push it about.
  [[nodiscard]] bool is_weak_hold() const { return is_weak_hold_; }
  /// Those of parts without any constraint.
  [[nodiscard]] const std::vector<int>& vertices_at_rest() const { return vertices_at_rest_; }
  /// The vertices of soft_diagonal() that are not 0.
  [[nodiscard]] const std::vector<int>& soft_vertices() const { return soft_vertices_; }
  /// Patches as averages over vertices, but for those that anchor a rigid region.
  [[nodiscard]] const std::vector<Average>& patches() const { return patches_; }
  /// Patches with most of their weight in one region, without what is outside of it: its few vertices would have to
  /// make up for whatever the region cannot follow, many times over. The region carries the whole patch's average.
  [[nodiscard]] const std::vector<Average>& anchor_patches() const { return anchor_patches_; }
  /// Their rows in the targets.
  [[nodiscard]] const std::vector<int>& patch_rows() const { return patch_rows_; }
  [[nodiscard]] const std::vector<int>& anchor_rows() const { return anchor_rows_; }
  /// All patches(), where a turn of a region moves any of them.
  [[nodiscard]] const MixedPatches& mixed_patches() const { return mixed_patches_; }
  /// Model vertex of each entry.
  [[nodiscard]] const std::vector<int>& entry_vertices() const { return entry_vertices_; }
  /// Parts of the mesh without any constraint.
  [[nodiscard]] const std::vector<int>& parts_at_rest() const { return parts_at_rest_; }

 private:
  void merge_entries(const PreparedModel& model, const ConstraintSet& set);
  void merge_patches(const PreparedModel& model, const ConstraintSet& set);
  void find_rest(const PreparedModel& model);
  void find_weak_hold(const PreparedModel& model);
  [[nodiscard]] std::vector<char> fixed_unknowns() const;
  [[nodiscard]] Eigen::VectorXd reduced_diagonal(const Eigen::VectorXd& diagonal) const;
  [[nodiscard]] std::vector<Average> reduced_patches() const;

  RigidRegions regions_;
  std::vector<int> entry_vertices_;
  std::vector<double> entry_shares_;
  std::vector<int> entries_by_vertex_;  ///< all of them, so that what is written is next to what was
  std::vector<char> is_constrained_;
  std::vector<char> is_hard_;
  std::vector<char> is_at_rest_;
  Eigen::VectorXd soft_diagonal_;
  std::vector<int> hard_vertices_;
  std::vector<int> vertices_at_rest_;
  std::vector<int> soft_vertices_;
  std::vector<Average> patches_;
  std::vector<Average> anchor_patches_;
  std::vector<RegionPoint> anchor_points_;
  std::vector<int> patch_rows_;
  std::vector<int> anchor_rows_;
  bool is_weak_hold_ = false;
  std::vector<int> parts_at_rest_;
  std::unique_ptr<ConstrainedSystem> system_;
  MixedPatches mixed_patches_;
  std::unique_ptr<ConstrainedSystem> laplacian_system_;
};

}  // namespace arap
