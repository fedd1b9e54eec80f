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
/// A row of the constraints becomes one of these:
///   - a fixed vertex, if it is hard and names one;
///   - an average, as patches are: hard rows if they are few or wide, or have members of rigid regions. With such
///     members and others, a row counts as hard from 1e4 times the stiffness of K on. Each average is a dense column of
///     the system: 8 bytes an unknown, the time of a solve to set, and little in an iteration;
///   - a soft row of the system: the other rows with members of rigid regions, and rows up to 200 times as stiff as K;
///   - a stiff row of the system: all others. Hard ones become 1e7 times as stiff as K at their unknowns, which holds
///     them to some 1e-9 of the model's size, and where they contradict each other to the least squares.
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
  /// The rows of patches(), then of stiff_rows().
  [[nodiscard]] Positions held_targets(const Positions& targets) const { return targets(held_rows_, all); }
  /// The rows of the patches that anchor regions.
  [[nodiscard]] Positions anchor_targets(const Positions& targets) const { return targets(anchor_rows_, all); }
  /// Of patches() and stiff_rows(), targets minus what positions have.
  [[nodiscard]] Positions held_gaps(Positions held_targets, const Positions& positions, const Workers& workers) const;
  /// b += factor * C^T multipliers, C the rows of both.
  void add_held_forces(double factor, const Positions& multipliers, const Workers& workers, Positions& b) const;

  /// (n_targets, 3): where what is constrained is.
  [[nodiscard]] Positions constrained_points(const Positions& positions) const;

  [[nodiscard]] const RigidRegions& regions() const { return regions_; }
  [[nodiscard]] const ConstrainedSystem& system() const { return *system_; }

  /// min |K x - K rest|^2 under the same constraints; made on the first call.
  [[nodiscard]] const ConstrainedSystem& laplacian_system(const PreparedModel& model);
  /// Rows as strong in it as they are beside K, whose diagonal this is.
  [[nodiscard]] static LinearRows laplacian_rows(LinearRows rows, const Eigen::VectorXd& diagonal);
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
  /// Rows of the system's matrix, over vertices.
  struct Rows {
    LinearRows rows;
    RowMatrix matrix;
    std::vector<int> target_rows;  ///< in the targets
  };
  [[nodiscard]] const Rows& soft_rows() const { return soft_rows_; }
  [[nodiscard]] const Rows& stiff_rows() const { return stiff_rows_; }
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

  [[nodiscard]] SystemConstraints system_constraints(const Eigen::VectorXd& soft_diagonal, LinearRows soft_rows,
                                                     LinearRows stiff_rows) const;

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
  Rows soft_rows_;
  Rows stiff_rows_;
  std::vector<int> held_rows_;
  Eigen::VectorXd target_sums_;
  bool is_weak_hold_ = false;
  std::vector<int> parts_at_rest_;
  std::unique_ptr<ConstrainedSystem> system_;
  MixedPatches mixed_patches_;
  std::unique_ptr<ConstrainedSystem> laplacian_system_;
};

}  // namespace arap
