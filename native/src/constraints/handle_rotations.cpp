// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/handle_rotations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>

#include "base/eigen_compat.h"
#include "base/union_find.h"
#include "dense/small_matrices.h"
#include "geometry/rotation.h"
#include "geometry/rotation_vectors.h"

namespace arap {

namespace {

/// At most `count` of the rows: the strongest, and of equally strong ones evenly.
std::vector<int> thinned(const std::vector<int>& rows, const std::vector<double>& weights, size_t count) {
  if (rows.size() <= count) return rows;
  std::vector<double> sorted;
  sorted.reserve(rows.size());
  for (const int k : rows) sorted.push_back(weights[k]);
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count) - 1, sorted.end(),
                   std::greater<>());
  std::vector<int> strong;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(strong),
               [&](int k) { return weights[k] >= sorted[count - 1]; });
  std::vector<int> result;
  result.reserve(count);
  for (size_t k = 0; k < count; ++k) result.push_back(strong[k * strong.size() / count]);
  return result;
}

}  // namespace

HandleRotations::HandleRotations(const PreparedModel& model, const PreparedConstraints& constraints)
    : model_(model), constraints_(constraints) {
  constexpr size_t kSamples = 1000;
  const auto n = static_cast<int>(model.rest.rows());
  const auto row_groups = {&constraints.soft_rows, &constraints.stiff_rows};
  std::vector<int> vertex_of_row(constraints.target_sums.size(), -1);
  weight_of_row_.assign(vertex_of_row.size(), 1);
  std::vector<char> is_constrained(n, 0);
  for (const PreparedConstraints::Entry& entry : constraints.entries) {
    vertex_of_row[entry.row] = entry.vertex;
    is_constrained[entry.vertex] = 1;
  }
  UnionFind joined(n);
  for (const int v : vertex_of_row) {
    if (v < 0) continue;
    for (SparseMatrix::InnerIterator it(model.energy.K, v); it; ++it)
      if (is_constrained[it.row()] != 0) joined.join(v, static_cast<int>(it.row()));
  }
  for (const PreparedConstraints::Rows* group : row_groups) {
    const LinearRows& rows = group->rows;
    const bool has_patches = group == &constraints.stiff_rows;
    for (int r = 0; r < rows.size() - (has_patches ? constraints.n_stiff_patches : 0); ++r) {
      const int first = rows.rows[r].indices.front();
      vertex_of_row[group->target_rows[r]] = first;
      weight_of_row_[group->target_rows[r]] = rows.weights[r];
      for (const int v : rows.rows[r].indices) joined.join(first, v);
    }
  }
  const std::vector<int>& handles = constraints.handle_of_row;
  const size_t first_told = vertex_of_row.size() - handles.size();

  std::vector<int> group_of_root(n, -1);
  group_of_row_.assign(vertex_of_row.size(), -1);
  for (const int v : constraints.vertex_of_target) part_of_row_.push_back(model.part_of_vertex[v]);
  std::map<int, int> group_of_handle;
  for (size_t k = 0; k < vertex_of_row.size(); ++k) {
    const bool is_told = k >= first_told;
    if (!is_told && vertex_of_row[k] < 0) continue;
    int& group = is_told ? group_of_handle.try_emplace(handles[k - first_told], -1).first->second
                         : group_of_root[joined.find(vertex_of_row[k])];
    if (group < 0) {
      group = static_cast<int>(rows_of_group_.size());
      rows_of_group_.emplace_back();
    }
    rows_of_group_[group].push_back(static_cast<int>(k));
    group_of_row_[k] = group;
  }
  for (std::vector<int>& of_group : rows_of_group_) of_group = thinned(of_group, weight_of_row_, kSamples);
}

double HandleRotations::sum_of(int row) const {
  const double sum = constraints_.target_sums[row];
  return std::abs(sum) > 1e-9 ? sum : 0;
}

std::optional<Matrix3> HandleRotations::best_rotation(const Positions& from, const Positions& to,
                                                      const std::vector<int>& rows) const {
  if (rows.size() < 3) return std::nullopt;
  double squares = 0;
  Eigen::RowVector3d mean_from = Eigen::RowVector3d::Zero();
  Eigen::RowVector3d mean_to = Eigen::RowVector3d::Zero();
  for (const int k : rows) {
    const double share = weight_of_row_[k] * sum_of(k);
    squares += share * sum_of(k);
    mean_from += share * from.row(k);
    mean_to += share * to.row(k);
  }
  if (squares > 0) {
    mean_from /= squares;
    mean_to /= squares;
  }
  Matrix3 S = Matrix3::Zero();
  Matrix3 scatter = Matrix3::Zero();
  for (const int k : rows) {
    const Eigen::RowVector3d arm = from.row(k) - sum_of(k) * mean_from;
    S += weight_of_row_[k] * (to.row(k) - sum_of(k) * mean_to).transpose() * arm;
    scatter += weight_of_row_[k] * arm.transpose() * arm;
  }
  const Vector3 widths = symmetric_eigenvalues(scatter);  // squared
  constexpr double kFlat = 1e-8;  // squared: a width of 1e-4 of the length determines a rotation about it
  if (widths[1] <= kFlat * widths[2]) return std::nullopt;
  return nearest_rotation(S, Matrix3::Identity());
}

HandleRotations::Told HandleRotations::ask_groups(const Positions& from, const Positions& to) const {
  Told told;
  told.reserve(rows_of_group_.size());
  for (const std::vector<int>& rows : rows_of_group_) told.push_back(best_rotation(from, to, rows));
  return told;
}

Positions HandleRotations::of_rows(const Told& told, const Positions& last) const {
  std::vector<Matrix3> rotations;
  std::vector<int> tellers;  // a row of each group that tells a turn
  for (size_t g = 0; g < told.size(); ++g) {
    if (!told[g]) continue;
    rotations.push_back(*told[g]);
    tellers.push_back(rows_of_group_[g].front());
  }
  Positions turns = rotation_vectors(rotations);
  if (last.rows() > 0) go_on_from(last(tellers, all), turns);
  // Part -1, that of loose vertices, comes first.
  Positions means = Positions::Zero(model_.n_parts + 1, 3);
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(means.rows());
  for (size_t t = 0; t < tellers.size(); ++t) {
    means.row(part_of_row_[tellers[t]] + 1) += turns.row(static_cast<Eigen::Index>(t));
    ++counts[part_of_row_[tellers[t]] + 1];
  }
  means.array().colwise() /= counts.array().max(1);
  std::vector<int> turn_of_group(told.size(), -1);
  for (size_t t = 0; t < tellers.size(); ++t) turn_of_group[group_of_row_[tellers[t]]] = static_cast<int>(t);
  Positions result(group_of_row_.size(), 3);
  for (size_t k = 0; k < group_of_row_.size(); ++k) {
    const int turn = group_of_row_[k] < 0 ? -1 : turn_of_group[group_of_row_[k]];
    result.row(k) = turn < 0 ? means.row(part_of_row_[k] + 1) : turns.row(turn);
  }
  return result;
}

Positions HandleRotations::estimate(const Positions& from, const Positions& to, const Positions& last) const {
  const Told told = ask_groups(from, to);
  if (std::any_of(told.begin(), told.end(), [](const auto& r) { return r.has_value(); })) return of_rows(told, last);
  std::vector<int> rows(group_of_row_.size());
  std::iota(rows.begin(), rows.end(), 0);
  Positions turn = rotation_vectors(std::array{best_rotation(from, to, rows).value_or(Matrix3::Identity())});
  if (last.rows() > 0) go_on_from(last.topRows(1), turn);
  return turn.replicate(from.rows(), 1);
}

Positions HandleRotations::from_rest(const Positions& targets, std::span<const Matrix3> rotations,
                                     const Positions& last) const {
  if (rotations.empty()) return estimate(constraints_.constrained_points(model_.rest), targets, last);
  Positions turns = rotation_vectors(rotations);
  if (last.rows() > 0) go_on_from(last, turns);
  return turns;
}

Positions HandleRotations::estimate_beyond(double angle, const Positions& from, const Positions& to) const {
  const Told told = ask_groups(from, to);
  const bool is_beyond = std::any_of(told.begin(), told.end(), [&](const std::optional<Matrix3>& rotation) {
    return rotation && Eigen::AngleAxisd(*rotation).angle() > angle;
  });
  return is_beyond ? of_rows(told, {}) : Positions(0, 3);
}

Positions HandleRotations::of_start(InitialGuess guess, const Positions& last_targets, const Positions& previous,
                                    const Positions& targets, std::span<const Matrix3> rotations) const {
  // Below that a global step with the former rotations starts as well.
  constexpr double kLargeTurn = std::numbers::pi / 8;
  if (guess == InitialGuess::kHandleRotations) return from_rest(targets, rotations);
  // What is held so weakly need not be near its targets: their turn is not its own.
  if (guess != InitialGuess::kPrevious || constraints_.is_weak_hold) return {};
  // What is constrained softly may never be at its target, so targets are compared with targets.
  const bool has_last = last_targets.rows() > 0;
  if (has_last && last_targets == targets) return {};
  return estimate_beyond(kLargeTurn, has_last ? last_targets : constraints_.constrained_points(previous), targets);
}

}  // namespace arap
