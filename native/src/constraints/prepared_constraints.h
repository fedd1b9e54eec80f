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

/// What is constrained on a model, in its numbers. Targets come in this order: vertices, patches, rows.
struct ModelConstraints {
  ConstraintSet set;  ///< a vertex may have several entries
  LinearRows rows;

  [[nodiscard]] int size() const { return set.size() + rows.size(); }
};

/// A set of constraints, prepared for a model: entries on the same vertex are merged, each unknown is fixed or free,
/// and the system is factorized. Nothing changes later but the second system, which a naive Laplacian guess makes.
///
/// A row of the constraints becomes one of three things:
///   - a fixed vertex, if it is hard and names one;
///   - an average, as patches are: hard rows if they are few, or wide, or have members of rigid regions. Each is a
///   dense
///     column of the system: 8 bytes an unknown, the time of a solve to set, and little in an iteration. [Which are few
///     is measured; see kMostDense.]
///   - a soft row in the matrix of the system: all others. A hard one is 1e8 times as stiff as K there, which holds it
///   to
///     about 1e-9 of the model's size.
class PreparedConstraints {
 public:
  /// Throws InvalidInput, SolverError or Cancelled.
  PreparedConstraints(const PreparedModel& model, const ModelConstraints& constraints, const Progress& progress);
  PreparedConstraints(const PreparedConstraints&) = delete;
  PreparedConstraints& operator=(const PreparedConstraints&) = delete;

  /// Writes the rows of constrained vertices. A vertex with several entries takes their mean, weighted by strength.
  /// @param targets    (n_targets, 3) on the model
  /// @param of_vertex  (n, 3)
  void write_vertex_targets(const Positions& targets, Positions& of_vertex) const;
  /// The rows of patches(), and of the patches that anchor regions.
  [[nodiscard]] Positions patch_targets(const Positions& targets) const { return targets(patch_rows_, all); }
  [[nodiscard]] Positions anchor_targets(const Positions& targets) const { return targets(anchor_rows_, all); }
  /// The rows of soft_rows().
  [[nodiscard]] Positions soft_row_targets(const Positions& targets) const { return targets(soft_row_rows_, all); }

  /// (n_targets, 3): where what is constrained is.
  [[nodiscard]] Positions constrained_points(const Positions& positions) const;

  [[nodiscard]] const RigidRegions& regions() const { return regions_; }
  [[nodiscard]] const ConstrainedSystem& system() const { return *system_; }

  /// min |K x - K rest|^2 under the same constraints; made on the first call.
  [[nodiscard]] const ConstrainedSystem& laplacian_system(const PreparedModel& model);
  /// soft_rows() as strong in it as they are beside K, whose diagonal this is.
  [[nodiscard]] LinearRows laplacian_rows(const Eigen::VectorXd& diagonal) const;
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
  /// Rows in the matrix of the system, over vertices, with finite weights.
  [[nodiscard]] const LinearRows& soft_rows() const { return soft_rows_; }
  /// Their rows in the targets.
  [[nodiscard]] const std::vector<int>& soft_row_rows() const { return soft_row_rows_; }
  [[nodiscard]] const RowMatrix& soft_row_matrix() const { return soft_row_matrix_; }
  /// What a rotation vector that all unknowns have makes of each target, (n_targets,): 1 but for rows of another sum.
  [[nodiscard]] const Eigen::VectorXd& target_sums() const { return target_sums_; }
  /// Patches as averages over vertices, but for those that anchor a rigid region.
  [[nodiscard]] const std::vector<LinearRow>& patches() const { return patches_; }
  /// Patches with most of their weight in one region, without what is outside of it: its few vertices would have to
  /// make up for whatever the region cannot follow, many times over. The region carries the whole patch's average.
  [[nodiscard]] const std::vector<LinearRow>& anchor_patches() const { return anchor_patches_; }
  /// Their rows in the targets.
  [[nodiscard]] const std::vector<int>& patch_rows() const { return patch_rows_; }
  [[nodiscard]] const std::vector<int>& anchor_rows() const { return anchor_rows_; }
  /// All patches(), where a turn of a region moves any of them.
  [[nodiscard]] const MixedPatches& mixed_patches() const { return mixed_patches_; }
  /// A target of one vertex.
  struct Entry {
    int vertex;
    int row;          ///< in the targets
    double strength;  ///< as in ConstraintSet
    double scale;     ///< what the target is multiplied with
  };
  /// In the order of vertices.
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  /// Parts of the mesh without any constraint.
  [[nodiscard]] const std::vector<int>& parts_at_rest() const { return parts_at_rest_; }

 private:
  void read_entries(const ConstraintSet& set);
  /// @param first  row of the targets
  void read_rows(const PreparedModel& model, const LinearRows& rows, int first);
  void merge_entries(const PreparedModel& model);
  void read_patch(const PreparedModel& model, const ConstraintSet& set, int p);
  /// A weighted average, of sum 1, whose weights are not negative, may anchor a region.
  void add_average(const PreparedModel& model, LinearRow average, int row, bool may_anchor);
  void find_rest(const PreparedModel& model);
  void find_weak_hold(const PreparedModel& model);
  void require_movable(const ConstraintSet& set, const std::vector<char>& is_fixed) const;
  [[nodiscard]] std::vector<char> fixed_unknowns() const;
  [[nodiscard]] SystemConstraints system_constraints(const Eigen::VectorXd& soft_diagonal, LinearRows rows) const;

  RigidRegions regions_;
  std::vector<Entry> entries_;  ///< by vertex, so that what is written is next to what was
  std::vector<char> is_constrained_;
  std::vector<char> is_hard_;
  std::vector<char> is_at_rest_;
  Eigen::VectorXd soft_diagonal_;
  std::vector<int> hard_vertices_;
  std::vector<int> vertices_at_rest_;
  std::vector<int> soft_vertices_;
  std::vector<LinearRow> patches_;
  std::vector<LinearRow> anchor_patches_;
  std::vector<RegionPoint> anchor_points_;
  std::vector<int> patch_rows_;
  std::vector<int> anchor_rows_;
  LinearRows soft_rows_;
  RowMatrix soft_row_matrix_;
  std::vector<int> soft_row_rows_;
  Eigen::VectorXd target_sums_;
  bool is_weak_hold_ = false;
  std::vector<int> parts_at_rest_;
  std::unique_ptr<ConstrainedSystem> system_;
  MixedPatches mixed_patches_;
  std::unique_ptr<ConstrainedSystem> laplacian_system_;
};

}  // namespace arap
