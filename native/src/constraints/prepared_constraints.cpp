// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/prepared_constraints.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "cholesky/solver_choice.h"
#include "sparse/sparse.h"

namespace arap {

namespace {

/// From here on a soft constraint is stiffer than the factor can tell from a hard one.
constexpr double kHardStrength = 1 - 1e-9;

/// A row counts as stiff, and as hard, from so many times the stiffness of K on.
constexpr double kStiffRow = 200;
constexpr double kHardRow = 1e7;

/// The same for a row with members in a rigid region and others. No stiff row has members of regions: softer ones are
/// soft rows, which would make the iteration slow if they were stiffer than this.
constexpr double kHardAtRim = 1e4;

/// Hard rows up to so many are dense columns. With 9,261 unknowns and rows of 27 entries, dense against stiff: 100 rows
/// are set in 0.23 against 0.20 s and iterate in 5.0 against 7.3 ms, 400 in 0.87 against 0.28 s and 13.0 against 11.4
/// ms.
constexpr int kMostDense = 100;

/// A row in the matrix joins all of its unknowns: a wide one would fill it.
constexpr int kMostEntries = 64;

}  // namespace

PreparedConstraints::PreparedConstraints(const PreparedModel& model, const ModelConstraints& constraints,
                                         const Progress& progress)
    : regions_(model.regions), target_sums_(Eigen::VectorXd::Ones(constraints.size())) {
  const auto n = static_cast<int>(model.rest.rows());
  constraints.rows.validate(n);
  read_entries(constraints.set);
  for (int p = 0; p < constraints.set.patches.size(); ++p) read_patch(model, constraints.set, p);
  read_rows(model, constraints.rows, constraints.set.size());
  merge_entries(model);
  for (Rows* group : {&soft_rows_, &stiff_rows_}) group->matrix = RowMatrix(group->rows, n);
  held_rows_ = patch_rows_;
  held_rows_.insert(held_rows_.end(), stiff_rows_.target_rows.begin(), stiff_rows_.target_rows.end());
  regions_.set_constraints(is_hard_, soft_diagonal_, anchor_points_, soft_rows_.rows);
  find_rest(model);
  find_weak_hold(model);
  SystemConstraints of_system = system_constraints(soft_diagonal_, soft_rows_.rows, stiff_rows_.rows);
  require_movable(constraints.set, of_system.is_fixed);
  system_ = std::make_unique<ConstrainedSystem>(*model.solver, model.linear_solver, model.system_matrix(),
                                                model.components, std::move(of_system), progress, model.workers);
  const auto is_mixed = [&](const LinearRow& patch) {
    return std::any_of(patch.indices.begin(), patch.indices.end(), [&](int v) { return regions_.is_in_region(v); });
  };
  if (std::any_of(patches_.begin(), patches_.end(), is_mixed))
    mixed_patches_ = MixedPatches(regions_, patches_, *system_);
}

void PreparedConstraints::require_movable(const ConstraintSet& set, const std::vector<char>& is_fixed) const {
  const int first_row = set.size();
  for (size_t p = 0; p < patches_.size(); ++p) {
    const bool can_move = std::any_of(patches_[p].indices.begin(), patches_[p].indices.end(),
                                      [&](int v) { return is_fixed[regions_.unknown_of(v)] == 0; });
    if (can_move) continue;
    const bool is_row = patch_rows_[p] >= first_row;
    throw InvalidInput(text(is_row ? "row " : "patch ",
                            patch_rows_[p] - (is_row ? first_row : static_cast<int>(set.vertices.size())),
                            " consists of hard vertices only; take it or them out of the constraints"));
  }
  for (int r = 0; r < stiff_rows_.rows.size(); ++r) {
    const LinearRow row = stiff_rows_.rows.row(r);
    if (std::any_of(row.indices.begin(), row.indices.end(),
                    [&](int v) { return is_fixed[regions_.unknown_of(v)] == 0; }))
      continue;
    throw InvalidInput(text("row ", stiff_rows_.target_rows[r] - first_row,
                            " consists of hard vertices only; take it or them out of the constraints"));
  }
}

void PreparedConstraints::read_entries(const ConstraintSet& set) {
  for (size_t k = 0; k < set.vertices.size(); ++k)
    entries_.push_back({set.vertices[k], static_cast<int>(k), set.strengths.empty() ? 1.0 : set.strengths[k], 1.0});
}

void PreparedConstraints::read_rows(const PreparedModel& model, const LinearRows& rows, int first) {
  if (rows.empty()) return;
  const Eigen::VectorXd stiffness = row_stiffness(RowMatrix(rows, static_cast<int>(model.rest.rows())), model.energy.K);
  for (int r = 0; r < rows.size(); ++r)
    if (std::isinf(stiffness[r]))
      throw InvalidInput(text("row ", r, " names isolated unknowns only, which nothing moves"));
  const auto is_stiffer = [&](int r, double than) { return rows.weights[r] >= than * stiffness[r]; };
  int n_hard = 0;
  for (int r = 0; r < rows.size(); ++r) n_hard += is_stiffer(r, kHardRow) ? 1 : 0;
  for (int r = 0; r < rows.size(); ++r) {
    LinearRow row = rows.row(r);
    target_sums_[first + r] = row.sum();
    const bool is_hard = is_stiffer(r, kHardRow);
    const auto is_member = [&](int v) { return regions_.is_in_region(v); };
    const bool is_in_region = std::any_of(row.indices.begin(), row.indices.end(), is_member);
    const bool is_within_one = is_in_region && std::all_of(row.indices.begin(), row.indices.end(), [&](int v) {
                                 return regions_.unknown_of(v) == regions_.unknown_of(row.indices.front());
                               });
    const bool is_dense = n_hard <= kMostDense || std::ssize(row.indices) > kMostEntries;
    if (is_hard && row.indices.size() == 1) {
      entries_.push_back({row.indices.front(), first + r, 1.0, 1 / row.coefficients.front()});
    } else if (is_in_region ? is_stiffer(r, is_within_one ? kHardRow : kHardAtRim) : is_hard && is_dense) {
      add_average(model, std::move(row), first + r, false);
    } else {
      // A region rotates with soft rows and averages, which take part in the choice of its rotation.
      Rows& group = is_stiffer(r, kStiffRow) && !is_in_region ? stiff_rows_ : soft_rows_;
      group.rows.add(row, std::min(rows.weights[r], kHardRow * stiffness[r]));
      group.target_rows.push_back(first + r);
    }
  }
}

void PreparedConstraints::merge_entries(const PreparedModel& model) {
  const auto n = static_cast<int>(model.rest.rows());
  std::vector<double> strength(n, 0.0);
  std::vector<double> strength_sum(n, 0.0);
  for (const Entry& entry : entries_) {
    strength[entry.vertex] = std::max(strength[entry.vertex], entry.strength);
    strength_sum[entry.vertex] += entry.strength;
  }
  for (Entry& entry : entries_) entry.scale *= entry.strength / strength_sum[entry.vertex];
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.vertex < b.vertex; });

  is_constrained_.assign(n, 0);
  is_hard_.assign(n, 0);
  soft_diagonal_ = Eigen::VectorXd::Zero(n);
  const Eigen::VectorXd stiffness = model.energy.K.diagonal();
  for (int v = 0; v < n; ++v) {
    const double s = strength[v];
    if (!(s > 0)) continue;
    is_constrained_[v] = 1;
    // A loose vertex has nothing that pulls it from its target.
    if (s >= kHardStrength || !(stiffness[v] > 0)) {
      is_hard_[v] = 1;
      hard_vertices_.push_back(v);
    } else {
      soft_diagonal_[v] = 2 * stiffness[v] * s / (1 - s);
      soft_vertices_.push_back(v);
    }
  }
}

void PreparedConstraints::read_patch(const PreparedModel& model, const ConstraintSet& set, int p) {
  std::map<int, double> weight_of_vertex;
  double sum = 0;
  for (int k = set.patches.offsets[p]; k < set.patches.offsets[p + 1]; ++k) {
    if (!(set.patches.weights[k] > 0)) continue;
    weight_of_vertex[set.patches.vertices[k]] += set.patches.weights[k];
    sum += set.patches.weights[k];
  }
  LinearRow average;
  for (const auto& [v, weight] : weight_of_vertex) {
    average.indices.push_back(v);
    average.coefficients.push_back(weight / sum);
  }
  add_average(model, std::move(average), static_cast<int>(set.vertices.size()) + p, true);
}

void PreparedConstraints::add_average(const PreparedModel& model, LinearRow average, int row, bool may_anchor) {
  if (const int region = may_anchor ? regions_.region_of(average) : -1; region >= 0) {
    anchor_patches_.push_back(regions_.inside_of(region, average));
    anchor_points_.push_back({region, average.of(model.rest).transpose()});
    anchor_rows_.push_back(row);
  } else {
    patches_.push_back(std::move(average));
    patch_rows_.push_back(row);
  }
}

void PreparedConstraints::find_rest(const PreparedModel& model) {
  const auto n = static_cast<int>(model.rest.rows());
  std::vector<char> is_component_constrained(n, 0);
  const auto component = [&](int v) { return model.components[regions_.unknown_of(v)]; };
  for (int v = 0; v < n; ++v)
    if (is_constrained_[v] != 0) is_component_constrained[component(v)] = 1;
  for (const std::vector<LinearRow>* patches : {&patches_, &anchor_patches_})
    for (const LinearRow& patch : *patches)
      for (const int v : patch.indices) is_component_constrained[component(v)] = 1;
  for (const Rows* group : {&soft_rows_, &stiff_rows_})
    for (const int v : group->rows.indices) is_component_constrained[component(v)] = 1;

  is_at_rest_.assign(n, 0);
  std::vector<char> is_part_constrained(model.n_parts, 0);
  for (int v = 0; v < n; ++v) {
    const bool is_constrained = is_component_constrained[component(v)] != 0;
    is_at_rest_[v] = is_constrained ? 0 : 1;
    if (!is_constrained) vertices_at_rest_.push_back(v);
    const int part = model.part_of_vertex[v];
    if (part >= 0 && is_constrained) is_part_constrained[part] = 1;
  }
  for (int part = 0; part < model.n_parts; ++part)
    if (is_part_constrained[part] == 0) parts_at_rest_.push_back(part);
}

void PreparedConstraints::find_weak_hold(const PreparedModel& model) {
  constexpr double kWeak = 0.01;  // of a vertex' own stiffness
  std::vector<double> hold(model.n_parts, 0.0);
  const auto strengthen = [&](int v, double by) {
    const int part = model.part_of_vertex[v];
    if (part >= 0) hold[part] = std::max(hold[part], by);
  };
  for (const int v : hard_vertices_) strengthen(v, 1);
  for (const std::vector<LinearRow>* patches : {&patches_, &anchor_patches_})
    for (const LinearRow& patch : *patches)
      for (const int v : patch.indices) strengthen(v, 1);
  const Eigen::VectorXd stiffness = model.energy.K.diagonal();
  for (const int v : soft_vertices_) strengthen(v, soft_diagonal_[v] / (2 * stiffness[v]));
  for (const int v : stiff_rows_.rows.indices) strengthen(v, 1);
  const LinearRows& soft = soft_rows_.rows;
  for (int r = 0; r < soft.size(); ++r)
    for (int k = soft.offsets[r]; k < soft.offsets[r + 1]; ++k)
      if (const int v = soft.indices[k]; stiffness[v] > 0)
        strengthen(v, soft.weights[r] * soft.coefficients[k] * soft.coefficients[k] / (2 * stiffness[v]));
  is_weak_hold_ = std::any_of(hold.begin(), hold.end(), [](double h) { return h > 0 && h < kWeak; });
}

std::vector<char> PreparedConstraints::fixed_unknowns() const {
  std::vector<char> is_fixed(is_hard_.size(), 0);
  for (size_t v = 0; v < is_hard_.size(); ++v) {
    const bool is_unknown = regions_.unknown_of(static_cast<int>(v)) == static_cast<int>(v);
    if (!is_unknown || is_hard_[v] != 0 || is_at_rest_[v] != 0) is_fixed[v] = 1;
  }
  for (int r = 0; r < regions_.size(); ++r)
    if (regions_.is_anchored(r)) is_fixed[regions_.unknown(r)] = 1;
  return is_fixed;
}

SystemConstraints PreparedConstraints::system_constraints(const Eigen::VectorXd& soft_diagonal, LinearRows soft_rows,
                                                          LinearRows stiff_rows) const {
  SystemConstraints result;
  result.is_fixed = fixed_unknowns();
  result.soft_diagonal = Eigen::VectorXd::Zero(soft_diagonal.size());
  for (Eigen::Index v = 0; v < soft_diagonal.size(); ++v)
    result.soft_diagonal[regions_.unknown_of(static_cast<int>(v))] += soft_diagonal[v];
  result.averages = patches_;
  for (LinearRow& average : result.averages)
    for (int& v : average.indices) v = regions_.unknown_of(v);
  result.soft_rows = std::move(soft_rows);
  result.stiff_rows = std::move(stiff_rows);
  for (LinearRows* rows : {&result.soft_rows, &result.stiff_rows})
    for (int& v : rows->indices) v = regions_.unknown_of(v);
  return result;
}

void PreparedConstraints::write_vertex_targets(const Positions& targets, Positions& of_vertex) const {
  for (const Entry& entry : entries_) of_vertex.row(entry.vertex).setZero();
  for (const Entry& entry : entries_) of_vertex.row(entry.vertex) += entry.scale * targets.row(entry.row);
}

Positions PreparedConstraints::held_gaps(Positions held_targets, const Positions& positions,
                                         const Workers& workers) const {
  for (size_t k = 0; k < patches_.size(); ++k) held_targets.row(static_cast<int>(k)) -= patches_[k].of(positions);
  if (stiff_rows_.matrix.empty()) return held_targets;
  Positions reached;
  stiff_rows_.matrix.multiply(positions, reached, workers);
  held_targets.bottomRows(reached.rows()) -= reached;
  return held_targets;
}

void PreparedConstraints::add_held_forces(double factor, const Positions& multipliers, const Workers& workers,
                                          Positions& b) const {
  if (multipliers.rows() == 0) return;
  for (size_t k = 0; k < patches_.size(); ++k)
    for (size_t i = 0; i < patches_[k].indices.size(); ++i)
      b.row(patches_[k].indices[i]) +=
          factor * patches_[k].coefficients[i] * multipliers.row(static_cast<Eigen::Index>(k));
  if (!stiff_rows_.matrix.empty())
    stiff_rows_.matrix.add_transposed(factor * multipliers.bottomRows(stiff_rows_.matrix.size()), b, workers);
}

Positions PreparedConstraints::constrained_points(const Positions& positions) const {
  Positions points(target_sums_.size(), 3);
  for (const Entry& entry : entries_) points.row(entry.row) = target_sums_[entry.row] * positions.row(entry.vertex);
  for (size_t k = 0; k < patches_.size(); ++k) points.row(patch_rows_[k]) = patches_[k].of(positions);
  for (const Rows* group : {&soft_rows_, &stiff_rows_})
    for (int r = 0; r < group->rows.size(); ++r) points.row(group->target_rows[r]) = group->rows.row(r).of(positions);
  if (anchor_points_.empty()) return points;
  const std::vector<Placement> placements = regions_.fit_placements(positions);
  for (size_t k = 0; k < anchor_points_.size(); ++k)
    points.row(anchor_rows_[k]) = regions_.carried(anchor_points_[k], placements).transpose();
  return points;
}

const ConstrainedSystem& PreparedConstraints::laplacian_system(const PreparedModel& model) {
  if (laplacian_system_ == nullptr) {
    const SparseMatrix K_squared = model.energy.K * model.energy.K;
    // The same strength as in the energy, measured in the diagonal of this system.
    const Eigen::VectorXd diagonal = model.energy.K.diagonal();
    const Eigen::VectorXd diagonal_squared = K_squared.diagonal();
    Eigen::VectorXd soft = soft_diagonal_;
    for (Eigen::Index v = 0; v < soft.size(); ++v)
      if (soft[v] > 0) soft[v] *= diagonal_squared[v] / diagonal[v];
    const SparseMatrix reduced = regions_.reduce(K_squared);
    laplacian_system_ = std::make_unique<ConstrainedSystem>(
        *make_linear_solver(reduced, model.linear_solver, model.workers), model.linear_solver, reduced,
        connected_components(reduced),
        system_constraints(soft, laplacian_rows(soft_rows_.rows, diagonal), laplacian_rows(stiff_rows_.rows, diagonal)),
        Progress{}, model.workers);
  }
  return *laplacian_system_;
}

LinearRows PreparedConstraints::laplacian_rows(LinearRows rows, const Eigen::VectorXd& diagonal) {
  for (int r = 0; r < rows.size(); ++r) {
    double mean = 0;
    for (int k = rows.offsets[r]; k < rows.offsets[r + 1]; ++k)
      mean += diagonal[rows.indices[k]] / (rows.offsets[r + 1] - rows.offsets[r]);
    rows.weights[r] *= mean;
  }
  return rows;
}

}  // namespace arap
