// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/prepared_constraints.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "cholesky/solver_choice.h"
#include "sparse/connected_components.h"

namespace arap {

namespace {

/// From here on a soft constraint is stiffer than the factor can tell from a hard one.
constexpr double kHardStrength = 1 - 1e-9;

}  // namespace

PreparedConstraints::PreparedConstraints(const PreparedModel& model, const ConstraintSet& set, const Progress& progress)
    : regions_(model.regions) {
  merge_entries(model, set);
  merge_patches(model, set);
  regions_.set_constraints(is_hard_, soft_diagonal_, anchor_points_);
  find_rest(model);
  find_weak_hold(model);
  const std::vector<char> is_fixed = fixed_unknowns();
  for (size_t p = 0; p < patches_.size(); ++p) {
    const bool can_move = std::any_of(patches_[p].indices.begin(), patches_[p].indices.end(),
                                      [&](int v) { return is_fixed[regions_.unknown_of(v)] == 0; });
    if (!can_move)
      throw InvalidInput(text("patch ", patch_rows_[p] - set.vertices.size(),
                              " consists of hard vertices only; take it or them out of the constraints"));
  }
  system_ =
      std::make_unique<ConstrainedSystem>(*model.solver, model.system_matrix(), model.components, is_fixed,
                                          reduced_diagonal(soft_diagonal_), reduced_patches(), progress, model.workers);
  const auto is_mixed = [&](const Average& patch) {
    return std::any_of(patch.indices.begin(), patch.indices.end(), [&](int v) { return regions_.is_in_region(v); });
  };
  if (std::any_of(patches_.begin(), patches_.end(), is_mixed))
    mixed_patches_ = MixedPatches(regions_, patches_, *system_);
}

void PreparedConstraints::merge_entries(const PreparedModel& model, const ConstraintSet& set) {
  const auto n = static_cast<int>(model.rest.rows());
  std::vector<double> strength(n, 0.0);
  std::vector<double> strength_sum(n, 0.0);
  for (size_t k = 0; k < set.vertices.size(); ++k) {
    const int v = set.vertices[k];
    entry_vertices_.push_back(v);
    strength[v] = std::max(strength[v], set.strengths[k]);
    strength_sum[v] += set.strengths[k];
  }
  for (size_t k = 0; k < set.vertices.size(); ++k)
    entry_shares_.push_back(set.strengths[k] / strength_sum[entry_vertices_[k]]);
  entries_by_vertex_.resize(entry_vertices_.size());
  std::iota(entries_by_vertex_.begin(), entries_by_vertex_.end(), 0);
  std::stable_sort(entries_by_vertex_.begin(), entries_by_vertex_.end(),
                   [&](int a, int b) { return entry_vertices_[a] < entry_vertices_[b]; });

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

void PreparedConstraints::merge_patches(const PreparedModel& model, const ConstraintSet& set) {
  for (int p = 0; p < set.patches.size(); ++p) {
    const int begin = set.patches.offsets[p];
    const int end = set.patches.offsets[p + 1];
    std::map<int, double> weight_of_vertex;
    double sum = 0;
    for (int k = begin; k < end; ++k) {
      const int v = set.patches.vertices[k];
      if (!(set.patches.weights[k] > 0)) continue;
      weight_of_vertex[v] += set.patches.weights[k];
      sum += set.patches.weights[k];
    }
    Average average;
    for (const auto& [v, weight] : weight_of_vertex) {
      average.indices.push_back(v);
      average.weights.push_back(weight / sum);
    }
    const int row = static_cast<int>(set.vertices.size()) + p;
    if (const int region = regions_.region_of(average); region >= 0) {
      anchor_patches_.push_back(regions_.inside_of(region, average));
      anchor_points_.push_back({region, average.of(model.rest).transpose()});
      anchor_rows_.push_back(row);
    } else {
      patches_.push_back(std::move(average));
      patch_rows_.push_back(row);
    }
  }
}

void PreparedConstraints::find_rest(const PreparedModel& model) {
  const auto n = static_cast<int>(model.rest.rows());
  std::vector<char> is_component_constrained(n, 0);
  const auto component = [&](int v) { return model.components[regions_.unknown_of(v)]; };
  for (int v = 0; v < n; ++v)
    if (is_constrained_[v] != 0) is_component_constrained[component(v)] = 1;
  for (const std::vector<Average>* patches : {&patches_, &anchor_patches_})
    for (const Average& patch : *patches)
      for (const int v : patch.indices) is_component_constrained[component(v)] = 1;

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
  for (const std::vector<Average>* patches : {&patches_, &anchor_patches_})
    for (const Average& patch : *patches)
      for (const int v : patch.indices) strengthen(v, 1);
  const Eigen::VectorXd stiffness = model.energy.K.diagonal();
  for (const int v : soft_vertices_) strengthen(v, soft_diagonal_[v] / (2 * stiffness[v]));
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

Eigen::VectorXd PreparedConstraints::reduced_diagonal(const Eigen::VectorXd& diagonal) const {
  Eigen::VectorXd reduced = Eigen::VectorXd::Zero(diagonal.size());
  for (Eigen::Index v = 0; v < diagonal.size(); ++v) reduced[regions_.unknown_of(static_cast<int>(v))] += diagonal[v];
  return reduced;
}

std::vector<Average> PreparedConstraints::reduced_patches() const {
  std::vector<Average> reduced = patches_;
  for (Average& patch : reduced)
    for (int& v : patch.indices) v = regions_.unknown_of(v);
  return reduced;
}

void PreparedConstraints::write_vertex_targets(const Positions& targets, Positions& of_vertex) const {
  for (const int k : entries_by_vertex_) of_vertex.row(entry_vertices_[k]).setZero();
  for (const int k : entries_by_vertex_) of_vertex.row(entry_vertices_[k]) += entry_shares_[k] * targets.row(k);
}

Positions PreparedConstraints::constrained_points(const Positions& positions) const {
  Positions points(entry_vertices_.size() + patches_.size() + anchor_patches_.size(), 3);
  for (size_t k = 0; k < entry_vertices_.size(); ++k) points.row(k) = positions.row(entry_vertices_[k]);
  for (size_t k = 0; k < patches_.size(); ++k) points.row(patch_rows_[k]) = patches_[k].of(positions);
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
        *make_linear_solver(reduced, model.linear_solver, model.workers), reduced, connected_components(reduced),
        fixed_unknowns(), reduced_diagonal(soft), reduced_patches(), Progress{}, model.workers);
  }
  return *laplacian_system_;
}

}  // namespace arap
