// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
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
  /// (n_rows,) the handle that each row is of; or empty: rows that share unknowns are of one.
  std::vector<int> handle_of_row{};  // NOLINT(readability-redundant-member-init): as in ConstraintSet

  [[nodiscard]] int n_targets() const { return set.n_targets() + rows.size(); }
};

/// A set of constraints, prepared for a model: entries on the same vertex are merged, each unknown is fixed or free,
/// and the system is factorized. Nothing changes later but the second system, which a naive Laplacian guess makes.
///
/// A row of the constraints becomes one of these:
///   - a fixed vertex, if it is hard and names one;
///   - an average: patches and hard rows if they are few or wide, or have members of rigid regions. With such
///     members and others, a row counts as hard from 1e4 times the stiffness of K on. Averages are joined by a small
///     dense system: see Border for the time and memory of each;
///   - a soft row of the system: the other rows with members of rigid regions, and rows up to 200 times as stiff as K;
///   - a stiff row of the system: all others. Hard ones become 1e7 times as stiff as K at their unknowns, which holds
///     them to some 1e-9 of the model's size, and where they contradict each other to the least squares. Patches are
///     met exactly, too.
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
  /// The rows of the patches, then of the stiff rows.
  [[nodiscard]] Positions held_targets(const Positions& targets) const { return targets(held_rows_, all); }
  /// The rows of the patches that anchor regions.
  [[nodiscard]] Positions anchor_targets(const Positions& targets) const { return targets(anchor_rows_, all); }
  /// Of patches and stiff rows, targets minus what positions have.
  [[nodiscard]] Positions held_gaps(Positions held_targets, const Positions& positions, const Workers& workers) const;
  /// Those of the mixed patches.
  [[nodiscard]] Positions mixed_gaps(const Positions& held_targets, const Positions& positions) const;
  /// b += factor * C^T multipliers, C the rows of both.
  void add_held_forces(double factor, const Positions& multipliers, const Workers& workers, Positions& b) const;

  /// (n_targets, 3): where what is constrained is.
  [[nodiscard]] Positions constrained_points(const Positions& positions) const;

  [[nodiscard]] const ConstrainedSystem& system() const { return *system_; }
  /// min |K x - K rest|^2 under the same constraints; made on the first call.
  [[nodiscard]] const ConstrainedSystem& laplacian_system(const PreparedModel& model);
  /// Rows as strong in it as they are beside K, whose diagonal this is.
  [[nodiscard]] static LinearRows laplacian_rows(LinearRows rows, const Eigen::VectorXd& diagonal);
  [[nodiscard]] bool has_laplacian_system() const { return laplacian_system_ != nullptr; }

  /// A target of one vertex.
  struct Entry {
    int vertex;
    int row;          ///< in the targets
    double strength;  ///< as in ConstraintSet
    double scale;     ///< what the target is multiplied with
  };
  /// Rows of the system's matrix, over vertices.
  struct Rows {
    LinearRows rows;
    RowMatrix matrix;
    std::vector<int> target_rows;  ///< in the targets
  };

  /// The model's, or those that stand for them.
  [[nodiscard]] const Cells& cells(const PreparedModel& model) const {
    return split_ == nullptr ? model.energy.cells : split_->cells;
  }
  [[nodiscard]] CellPasses& passes(const PreparedModel& model, Precision precision) const {
    return split_ == nullptr ? model.passes(precision) : split_passes_.of(model, split_->cells, precision);
  }
  void drop_passes() const noexcept { split_passes_.drop(); }
  /// Of cells that the model has not got, the model's cell that each is a part of.
  [[nodiscard]] std::span<const int> split_origins() const {
    return split_ == nullptr ? std::span<const int>() : std::span<const int>(split_->origins);
  }

  // To read only.
  RigidRegions regions;
  std::vector<Entry> entries;         ///< by vertex, so that what is written is next to what was
  std::vector<char> is_hard;          ///< (n,) vertices that sit exactly at their target
  std::vector<char> is_at_rest;       ///< (n,) loose vertices and those of components without constraint
  Eigen::VectorXd soft_diagonal;      ///< (n,) 2 omega of soft vertices, 0 elsewhere; omega_i = K_ii s / (1 - s)
  std::vector<int> hard_vertices;     ///< of is_hard
  std::vector<int> soft_vertices;     ///< of soft_diagonal
  std::vector<int> vertices_at_rest;  ///< of is_at_rest
  std::vector<int> parts_at_rest;     ///< of the mesh, without any constraint
  std::vector<LinearRow> patches;     ///< held as averages over vertices
  std::vector<RegionPoint>
      anchor_points;           ///< patches with most of their weight in one region, which carries them whole
  MixedPatches mixed_patches;  ///< of the patches, those that a rotation of a region moves
  Rows soft_rows;
  Rows stiff_rows;  ///< the last ones are patches
  int n_stiff_patches = 0;
  std::vector<int> vertex_of_target;  ///< (n_targets,) one that the target is about
  std::vector<int> handle_of_row;     ///< as given: of the last targets
  /// (n_targets,) what a rotation vector that all unknowns have makes of each target: 1 but for rows of another sum
  Eigen::VectorXd target_sums;
  bool is_weak_hold = false;  ///< if nothing holds a part but constraints so soft that rounded forces could push it

 private:
  void read_entries(const ConstraintSet& set);
  /// @param first  row of the targets
  void read_rows(const PreparedModel& model, const LinearRows& rows, int first);
  void merge_entries();
  /// After merge_entries(): where a patch is hard, it is not held again.
  void read_patches(const PreparedModel& model, const ConstraintSet& set);
  /// Patches that no region carries: averages, or stiff rows that are met exactly.
  void sort_patches(std::vector<LinearRow> averages, std::vector<int> targets);
  /// As row_stiffness(), of the vertices that are not hard.
  [[nodiscard]] double free_stiffness(const LinearRow& row) const;
  /// Calls visit(vertex, hold) for what each constraint names; hold is its stiffness as a part of K's there, at least
  /// 1 if it is hard.
  template <class Visit>
  void for_each_hold(const Visit& visit) const;
  void find_rest(const PreparedModel& model);
  /// (n,) which of the others hang together through cells of one vertex, beside the held ones, which have -1.
  [[nodiscard]] std::vector<int> cut_parts(const PreparedModel& model) const;
  /// Splits the cells where held vertices cut others from each other.
  void cut_cells(const PreparedModel& model, const Progress& progress);
  void find_weak_hold(const PreparedModel& model);
  void require_movable(const ConstraintSet& set, const std::vector<char>& is_fixed) const;
  [[nodiscard]] std::vector<char> fixed_unknowns() const;

  [[nodiscard]] SystemConstraints system_constraints(const Eigen::VectorXd& of_vertices, LinearRows soft,
                                                     LinearRows stiff) const;

  Eigen::VectorXd stiffness_;     ///< (n,) the diagonal of K
  std::vector<int> patch_rows_;   ///< of the patches in the targets
  std::vector<int> anchor_rows_;  ///< of the anchor points
  std::vector<int> held_rows_;
  std::unique_ptr<const SplitCells> split_;  ///< null: the cells are the model's
  mutable KeptPasses split_passes_;
  std::unique_ptr<ConstrainedSystem> system_;
  SparseMatrix laplacian_matrix_;  ///< K^2 over unknowns
  std::unique_ptr<ConstrainedSystem> laplacian_system_;
};

}  // namespace arap
