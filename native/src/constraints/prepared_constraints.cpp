// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/prepared_constraints.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"
#include "base/union_find.h"
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

/// Hard rows up to so many are averages: they make no new symbolic analysis, but a dense system as large as they are
/// many.
constexpr int kMostDense = 100;

/// A row in the matrix joins all of its unknowns: a wide one would fill it.
constexpr int kMostEntries = 64;

}  // namespace

PreparedConstraints::PreparedConstraints(const PreparedModel& model, const ModelConstraints& constraints,
                                         const Progress& progress)
    : regions(model.regions),
      vertex_of_target(constraints.n_targets()),
      handle_of_row(constraints.handle_of_row),
      target_sums(Eigen::VectorXd::Ones(constraints.n_targets())),
      stiffness_(model.energy.K.diagonal()) {
  const auto n = static_cast<int>(model.rest.rows());
  constraints.rows.validate(n);
  read_entries(constraints.set);
  read_rows(model, constraints.rows, constraints.set.n_targets());
  merge_entries();
  read_patches(model, constraints.set);
  for (Rows* group : {&soft_rows, &stiff_rows}) group->matrix = RowMatrix(group->rows, n);
  held_rows_ = patch_rows_;
  held_rows_.insert(held_rows_.end(), stiff_rows.target_rows.begin(), stiff_rows.target_rows.end());
  regions.set_constraints(is_hard, soft_diagonal, anchor_points, soft_rows.rows);
  find_rest(model);
  if (model.terms != nullptr) cut_cells(model, progress);
  find_weak_hold(model);
  SystemConstraints of_system = system_constraints(soft_diagonal, soft_rows.rows, stiff_rows.rows);
  require_movable(constraints.set, of_system.is_fixed);
  system_ = std::make_unique<ConstrainedSystem>(*model.solver, model.solver_factory, model.system_matrix(),
                                                model.components, std::move(of_system), progress, model.workers);
  mixed_patches = MixedPatches(regions, patches, *system_);
}

void PreparedConstraints::require_movable(const ConstraintSet& set, const std::vector<char>& is_fixed) const {
  const auto require = [&](const LinearRow& held, int target) {
    if (std::any_of(held.indices.begin(), held.indices.end(),
                    [&](int v) { return is_fixed[regions.unknown_of(v)] == 0; }))
      return;
    const bool is_row = target >= set.n_targets();
    throw InvalidInput(text(is_row ? "row " : "patch ",
                            target - (is_row ? set.n_targets() : static_cast<int>(set.vertices.size())),
                            " consists of hard vertices only; take it or them out of the constraints"));
  };
  for (size_t p = 0; p < patches.size(); ++p) require(patches[p], patch_rows_[p]);
  for (int r = 0; r < stiff_rows.rows.size(); ++r) require(stiff_rows.rows.rows[r], stiff_rows.target_rows[r]);
}

void PreparedConstraints::read_entries(const ConstraintSet& set) {
  for (size_t k = 0; k < set.vertices.size(); ++k) {
    entries.push_back({set.vertices[k], static_cast<int>(k), set.strengths.empty() ? 1.0 : set.strengths[k], 1.0});
    vertex_of_target[k] = set.vertices[k];
  }
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
    const LinearRow& row = rows.rows[r];
    const int vertex = row.indices.front();
    vertex_of_target[first + r] = vertex;
    target_sums[first + r] = row.sum();
    const bool is_hard_row = is_stiffer(r, kHardRow);
    const bool is_in_region = regions.has_member(row);
    const bool is_within_one = is_in_region && std::all_of(row.indices.begin(), row.indices.end(), [&](int v) {
                                 return regions.unknown_of(v) == regions.unknown_of(vertex);
                               });
    const bool is_dense = n_hard <= kMostDense || std::ssize(row.indices) > kMostEntries;
    if (is_hard_row && row.indices.size() == 1) {
      entries.push_back({vertex, first + r, 1.0, 1 / row.coefficients.front()});
    } else if (is_in_region ? is_stiffer(r, is_within_one ? kHardRow : kHardAtRim) : is_hard_row && is_dense) {
      patches.push_back(row);
      patch_rows_.push_back(first + r);
    } else {
      // A region rotates with soft rows and averages, which take part in the choice of its rotation.
      Rows& group = is_stiffer(r, kStiffRow) && !is_in_region ? stiff_rows : soft_rows;
      group.rows.add(row, std::min(rows.weights[r], kHardRow * stiffness[r]));
      group.target_rows.push_back(first + r);
    }
  }
}

void PreparedConstraints::merge_entries() {
  const auto n = static_cast<int>(stiffness_.size());
  std::vector<double> strength(n, 0.0);
  std::vector<double> strength_sum(n, 0.0);
  for (const Entry& entry : entries) {
    strength[entry.vertex] = std::max(strength[entry.vertex], entry.strength);
    strength_sum[entry.vertex] += entry.strength;
  }
  for (Entry& entry : entries) entry.scale *= entry.strength / strength_sum[entry.vertex];
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.vertex < b.vertex; });

  is_hard.assign(n, 0);
  soft_diagonal = Eigen::VectorXd::Zero(n);
  for (int v = 0; v < n; ++v) {
    const double s = strength[v];
    if (!(s > 0)) continue;
    // A loose vertex has nothing that pulls it from its target.
    if (s >= kHardStrength || !(stiffness_[v] > 0)) {
      is_hard[v] = 1;
      hard_vertices.push_back(v);
    } else {
      soft_diagonal[v] = 2 * stiffness_[v] * s / (1 - s);
      soft_vertices.push_back(v);
    }
  }
}

void PreparedConstraints::read_patches(const PreparedModel& model, const ConstraintSet& set) {
  std::vector<LinearRow> averages;
  std::vector<int> targets;
  for (int p = 0; p < set.patches.size(); ++p) {
    LinearRow average = average_of(set.patches, p, [](int) { return true; });
    const int target = static_cast<int>(set.vertices.size()) + p;
    vertex_of_target[target] = average.indices.front();
    if (const int region = regions.region_of(average); region >= 0) {
      vertex_of_target[target] = regions.unknown(region);
      anchor_points.push_back({region, average.of(model.rest).transpose()});
      anchor_rows_.push_back(target);
    } else {
      averages.push_back(std::move(average));
      targets.push_back(target);
    }
  }
  sort_patches(std::move(averages), std::move(targets));
}

void PreparedConstraints::sort_patches(std::vector<LinearRow> averages, std::vector<int> targets) {
  const auto is_narrow = [&](const LinearRow& row) {
    return std::ssize(row.indices) <= kMostEntries && !regions.has_member(row) && std::isfinite(free_stiffness(row));
  };
  const bool are_many = std::count_if(averages.begin(), averages.end(), is_narrow) > kMostDense;
  for (size_t p = 0; p < averages.size(); ++p) {
    LinearRow& row = averages[p];
    if (are_many && is_narrow(row)) {
      const double weight = kHardRow * free_stiffness(row);
      stiff_rows.rows.add(std::move(row), weight);
      stiff_rows.target_rows.push_back(targets[p]);
      ++n_stiff_patches;
    } else {
      patches.push_back(std::move(row));
      patch_rows_.push_back(targets[p]);
    }
  }
}

double PreparedConstraints::free_stiffness(const LinearRow& row) const {
  double compliance = 0;
  for (size_t k = 0; k < row.indices.size(); ++k)
    if (const int v = row.indices[k]; is_hard[v] == 0 && stiffness_[v] > 0)
      compliance += row.coefficients[k] * row.coefficients[k] / stiffness_[v];
  return compliance > 0 ? 1 / compliance : std::numeric_limits<double>::infinity();
}

template <class Visit>
void PreparedConstraints::for_each_hold(const Visit& visit) const {
  for (const int v : hard_vertices) visit(v, 1.0);
  for (const int v : soft_vertices) visit(v, soft_diagonal[v] / (2 * stiffness_[v]));
  for (const RegionPoint& point : anchor_points) visit(regions.unknown(point.region), 1.0);
  for (const std::vector<LinearRow>* hard : {&patches, &stiff_rows.rows.rows})
    for (const LinearRow& row : *hard)
      for (const int v : row.indices) visit(v, 1.0);
  for (int r = 0; r < soft_rows.rows.size(); ++r) {
    const auto& [indices, coefficients] = soft_rows.rows.rows[r];
    for (size_t k = 0; k < indices.size(); ++k) {
      const double by = soft_rows.rows.weights[r] * coefficients[k] * coefficients[k];
      visit(indices[k], stiffness_[indices[k]] > 0 ? by / (2 * stiffness_[indices[k]]) : 0.0);
    }
  }
}

void PreparedConstraints::find_rest(const PreparedModel& model) {
  const auto n = static_cast<int>(model.rest.rows());
  std::vector<char> is_component_constrained(n, 0);
  const auto component = [&](int v) { return model.components[regions.unknown_of(v)]; };
  for_each_hold([&](int v, double) { is_component_constrained[component(v)] = 1; });
  is_at_rest.assign(n, 0);
  std::vector<char> is_part_constrained(model.n_parts, 0);
  for (int v = 0; v < n; ++v) {
    const bool is_constrained = is_component_constrained[component(v)] != 0;
    is_at_rest[v] = is_constrained ? 0 : 1;
    if (!is_constrained) vertices_at_rest.push_back(v);
    const int part = model.part_of_vertex[v];
    if (part >= 0 && is_constrained) is_part_constrained[part] = 1;
  }
  for (int part = 0; part < model.n_parts; ++part)
    if (is_part_constrained[part] == 0) parts_at_rest.push_back(part);
}

std::vector<int> PreparedConstraints::cut_parts(const PreparedModel& model) const {
  std::vector<int> parts(is_hard.size(), -1);
  std::vector<char> is_free(is_hard.size(), 1);
  for (const int v : hard_vertices)
    if (!regions.has_member(v)) is_free[v] = 0;
  std::vector<char> is_held_region(is_hard.size(), 0);
  for (int r = 0; r < regions.size(); ++r) is_held_region[regions.unknown(r)] = regions.is_held(r) ? 1 : 0;
  for (int v = 0; v < std::ssize(is_free); ++v)
    if (is_held_region[regions.unknown_of(v)] != 0) is_free[v] = 0;
  UnionFind joined(static_cast<int>(is_free.size()));
  for (int v = 0; v < std::ssize(is_free); ++v) {
    if (is_free[v] != 0) joined.join(v, regions.unknown_of(v));
    // All neighbours of a vertex, as the cell of one vertex does: so also those on both sides of a line of held ones.
    // Also where the entry is 0, as of the diagonals of squares: their terms join them.
    int first = is_free[v] != 0 ? v : -1;
    for (SparseMatrix::InnerIterator it(model.energy.K, v); it; ++it) {
      const int neighbour = static_cast<int>(it.row());
      if (is_free[neighbour] == 0) continue;
      if (first < 0) first = neighbour;
      joined.join(first, neighbour);
    }
  }
  for (int v = 0; v < std::ssize(is_free); ++v)
    if (is_free[v] != 0) parts[v] = joined.find(v);
  return parts;
}

void PreparedConstraints::cut_cells(const PreparedModel& model, const Progress& progress) {
  Meter meter(progress, "the change of constraints was cancelled");
  split_ = split_cells(model.energy.cells, *model.terms, model.rest, cut_parts(model), regions.members(),
                       model.workers.threads(), {&meter, 0});
  if (split_ == nullptr) return;
  regions.read_cells(split_->cells);
  regions.set_constraints(is_hard, soft_diagonal, anchor_points, soft_rows.rows);
}

void PreparedConstraints::find_weak_hold(const PreparedModel& model) {
  constexpr double kWeak = 0.01;  // of a vertex' own stiffness
  std::vector<double> hold(model.n_parts, 0.0);
  for_each_hold([&](int v, double by) {
    const int part = model.part_of_vertex[v];
    if (part >= 0) hold[part] = std::max(hold[part], by);
  });
  is_weak_hold = std::any_of(hold.begin(), hold.end(), [](double h) { return h > 0 && h < kWeak; });
}

std::vector<char> PreparedConstraints::fixed_unknowns() const {
  std::vector<char> is_fixed(is_hard.size(), 0);
  for (size_t v = 0; v < is_hard.size(); ++v) {
    const bool is_unknown = regions.unknown_of(static_cast<int>(v)) == static_cast<int>(v);
    if (!is_unknown || is_hard[v] != 0 || is_at_rest[v] != 0) is_fixed[v] = 1;
  }
  for (int r = 0; r < regions.size(); ++r)
    if (regions.is_anchored(r)) is_fixed[regions.unknown(r)] = 1;
  return is_fixed;
}

SystemConstraints PreparedConstraints::system_constraints(const Eigen::VectorXd& of_vertices, LinearRows soft,
                                                          LinearRows stiff) const {
  SystemConstraints result{fixed_unknowns(), Eigen::VectorXd::Zero(of_vertices.size()),
                           patches,          std::move(soft),
                           std::move(stiff), n_stiff_patches};
  for (Eigen::Index v = 0; v < of_vertices.size(); ++v)
    result.soft_diagonal[regions.unknown_of(static_cast<int>(v))] += of_vertices[v];
  for (std::vector<LinearRow>* rows : {&result.averages, &result.soft_rows.rows, &result.stiff_rows.rows})
    for (LinearRow& row : *rows)
      for (int& v : row.indices) v = regions.unknown_of(v);
  return result;
}

void PreparedConstraints::write_vertex_targets(const Positions& targets, Positions& of_vertex) const {
  for (const Entry& entry : entries) of_vertex.row(entry.vertex).setZero();
  for (const Entry& entry : entries) of_vertex.row(entry.vertex) += entry.scale * targets.row(entry.row);
}

Positions PreparedConstraints::held_gaps(Positions held_targets, const Positions& positions,
                                         const Workers& workers) const {
  for (size_t k = 0; k < patches.size(); ++k) held_targets.row(static_cast<int>(k)) -= patches[k].of(positions);
  auto of_stiff = held_targets.bottomRows(stiff_rows.matrix.size());
  if (of_stiff.rows() > 0) of_stiff = stiff_rows.matrix.gaps(of_stiff, positions, workers);
  return held_targets;
}

Positions PreparedConstraints::mixed_gaps(const Positions& held_targets, const Positions& positions) const {
  const std::vector<int>& mixed = mixed_patches.patches();
  Positions gaps = held_targets(mixed, all);
  for (size_t k = 0; k < mixed.size(); ++k) gaps.row(static_cast<int>(k)) -= patches[mixed[k]].of(positions);
  return gaps;
}

void PreparedConstraints::add_held_forces(double factor, const Positions& multipliers, const Workers& workers,
                                          Positions& b) const {
  if (multipliers.rows() == 0) return;
  for (size_t k = 0; k < patches.size(); ++k)
    for (size_t i = 0; i < patches[k].indices.size(); ++i)
      b.row(patches[k].indices[i]) +=
          factor * patches[k].coefficients[i] * multipliers.row(static_cast<Eigen::Index>(k));
  if (!stiff_rows.matrix.empty())
    stiff_rows.matrix.add_transposed(factor * multipliers.bottomRows(stiff_rows.matrix.size()), b, workers);
}

Positions PreparedConstraints::constrained_points(const Positions& positions) const {
  Positions points(target_sums.size(), 3);
  for (const Entry& entry : entries) points.row(entry.row) = target_sums[entry.row] * positions.row(entry.vertex);
  for (size_t k = 0; k < patches.size(); ++k) points.row(patch_rows_[k]) = patches[k].of(positions);
  for (const Rows* group : {&soft_rows, &stiff_rows})
    for (int r = 0; r < group->rows.size(); ++r) points.row(group->target_rows[r]) = group->rows.rows[r].of(positions);
  if (anchor_points.empty()) return points;
  const std::vector<Placement> placements = regions.fit_placements(positions);
  for (size_t k = 0; k < anchor_points.size(); ++k)
    points.row(anchor_rows_[k]) = regions.carried(anchor_points[k], placements).transpose();
  return points;
}

const ConstrainedSystem& PreparedConstraints::laplacian_system(const PreparedModel& model) {
  if (laplacian_system_ == nullptr) {
    SparseMatrix K_squared = model.energy.K * model.energy.K;
    // The same strength as in the energy, measured in the diagonal of this system.
    const Eigen::VectorXd diagonal_squared = K_squared.diagonal();
    Eigen::VectorXd soft = soft_diagonal;
    for (Eigen::Index v = 0; v < soft.size(); ++v)
      if (soft[v] > 0) soft[v] *= diagonal_squared[v] / stiffness_[v];
    if (regions.empty())
      laplacian_matrix_.swap(K_squared);
    else
      laplacian_matrix_ = regions.reduce(K_squared);
    laplacian_system_ = std::make_unique<ConstrainedSystem>(
        *make_linear_solver(laplacian_matrix_, model.workers, TileFormat::kHalf, {}, model.solver_factory),
        model.solver_factory, laplacian_matrix_, connected_components(laplacian_matrix_),
        system_constraints(soft, laplacian_rows(soft_rows.rows, stiffness_),
                           laplacian_rows(stiff_rows.rows, stiffness_)),
        Progress{}, model.workers);
  }
  return *laplacian_system_;
}

LinearRows PreparedConstraints::laplacian_rows(LinearRows rows, const Eigen::VectorXd& diagonal) {
  for (int r = 0; r < rows.size(); ++r) rows.weights[r] *= diagonal(rows.rows[r].indices).mean();
  return rows;
}

}  // namespace arap
