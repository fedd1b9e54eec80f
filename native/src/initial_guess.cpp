// SPDX-License-Identifier: GPL-3.0-or-later
#include "initial_guess.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>

#include "rotation.h"
#include "union_find.h"

namespace arap {

namespace {

/// Pairs of rest points and targets, and the rotation between them.
class PointPairs {
 public:
  void add(const Vector3& rest, const Vector3& target) {
    rest_.push_back(rest);
    target_.push_back(target);
  }

  void add(const PointPairs& other) {
    rest_.insert(rest_.end(), other.rest_.begin(), other.rest_.end());
    target_.insert(target_.end(), other.target_.begin(), other.target_.end());
  }

  /// Empty where the points lie on a line or in one place.
  [[nodiscard]] std::optional<Matrix3> rotation() const {
    Vector3 mean_rest = Vector3::Zero();
    Vector3 mean_target = Vector3::Zero();
    for (size_t k = 0; k < rest_.size(); ++k) {
      mean_rest += rest_[k] / static_cast<double>(rest_.size());
      mean_target += target_[k] / static_cast<double>(rest_.size());
    }
    Matrix3 S = Matrix3::Zero();
    Matrix3 scatter = Matrix3::Zero();
    for (size_t k = 0; k < rest_.size(); ++k) {
      S += (target_[k] - mean_target) * (rest_[k] - mean_rest).transpose();
      scatter += (rest_[k] - mean_rest) * (rest_[k] - mean_rest).transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(scatter, Eigen::EigenvaluesOnly);
    constexpr double kFlat = 1e-8;  // squared: a width of 1e-4 of the length determines a rotation about it
    if (eigen.eigenvalues()[1] <= kFlat * eigen.eigenvalues()[2]) return std::nullopt;
    return nearest_rotation(S, Matrix3::Identity());
  }

 private:
  std::vector<Vector3> rest_;
  std::vector<Vector3> target_;
};

}  // namespace

void guess_naive_laplacian(const BoundModel& model, BoundConstraints& constraints, const Positions& vertex_targets,
                           const Positions& patch_targets, Pose& pose) {
  const ConstrainedSystem& system = constraints.laplacian_system(model);
  const RigidRegions& regions = constraints.regions();
  Positions gap = model.rest - pose.positions;
  Positions laplacian;
  Positions residual;
  multiply(model.energy.K, gap, laplacian, model.threads);
  multiply(model.energy.K, laplacian, residual, model.threads);
  const Eigen::VectorXd diagonal = model.energy.K.diagonal();
  const Eigen::VectorXd& soft = constraints.soft_diagonal();
  for (Eigen::Index v = 0; v < soft.size(); ++v) {
    if (!(soft[v] > 0)) continue;
    const double diagonal_squared = model.energy.K.col(v).squaredNorm();
    residual.row(v) += soft[v] * diagonal_squared / diagonal[v] * (vertex_targets.row(v) - pose.positions.row(v));
  }
  Positions patch_gaps = patch_targets;
  for (Eigen::Index k = 0; k < patch_gaps.rows(); ++k) patch_gaps.row(k) -= constraints.patches()[k].of(pose.positions);
  regions.reduce(residual);
  system.correct_exactly(residual, patch_gaps);
  regions.expand(residual);
  pose.positions += residual;
  regions.read_translations(pose.placements, pose.positions);
}

void spread_handle_rotations(const BoundModel& model, const BoundConstraints& constraints,
                             std::span<const Matrix3> rotations, Pose& pose) {
  const ConstrainedSystem& system = constraints.system();
  const RigidRegions& regions = constraints.regions();
  const auto n = model.rest.rows();
  const auto& entries = constraints.entry_vertices();
  const std::ptrdiff_t n_patches = std::ssize(constraints.patches());

  // field[a] holds row a of the rotation of every vertex.
  std::array<Positions, 3> field;
  for (Eigen::Index a = 0; a < 3; ++a) {
    Positions& x = field[a];
    x = Positions::Zero(n, 3);
    x.col(a).setOnes();  // identity, where nothing is constrained
    Positions residual = Positions::Zero(n, 3);
    for (size_t k = 0; k < entries.size(); ++k) {
      const int v = entries[k];
      if (constraints.is_hard()[v] != 0) x.row(regions.unknown_of(v)) = rotations[k].row(a);
    }
    for (size_t k = 0; k < constraints.anchor_patches().size(); ++k)
      x.row(regions.unknown_of(constraints.anchor_patches()[k].indices.front())) =
          rotations[constraints.anchor_rows()[k]].row(a);
    Positions pull;
    multiply(system.matrix(), x, pull, model.threads);
    for (size_t k = 0; k < entries.size(); ++k)
      residual.row(regions.unknown_of(entries[k])) += constraints.soft_diagonal()[entries[k]] * rotations[k].row(a);
    residual -= pull;
    Positions gaps(n_patches, 3);
    for (Eigen::Index k = 0; k < n_patches; ++k)
      gaps.row(k) = rotations[constraints.patch_rows()[k]].row(a) - system.averages()[k].of(x);
    system.correct_exactly(residual, gaps);
    x += residual;
  }

  const auto rotation_at = [&](int unknown, const Matrix3& previous) {
    Matrix3 blend;
    for (Eigen::Index a = 0; a < 3; ++a) blend.row(a) = field[a].row(unknown);
    return nearest_rotation(blend, previous);
  };
  for (int c = 0; c < model.energy.n_cells(); ++c)
    if (const int home = model.energy.home(c); home >= 0)
      pose.rotations[c] = rotation_at(regions.unknown_of(home), pose.rotations[c].toRotationMatrix());
  for (int r = 0; r < regions.size(); ++r) {
    Placement& placement = pose.placements[r];
    if (!regions.is_anchored(r)) placement.rotation = rotation_at(regions.unknown(r), placement.rotation);
  }
  regions.write(pose.placements, pose.positions);
  regions.share_rotations(pose.placements, pose.rotations);
}

std::vector<Matrix3> estimate_rotations(const BoundModel& model, const BoundConstraints& constraints,
                                        const Positions& targets) {
  const auto& entries = constraints.entry_vertices();
  std::vector<char> is_constrained(model.rest.rows(), 0);
  for (const int v : entries) is_constrained[v] = 1;
  UnionFind groups(static_cast<int>(model.rest.rows()));
  for (const int v : entries)
    for (SparseMatrix::InnerIterator it(model.energy.K, v); it; ++it)
      if (is_constrained[it.row()] != 0) groups.join(v, static_cast<int>(it.row()));

  std::map<int, PointPairs> pairs_of_group;
  PointPairs all;
  for (size_t k = 0; k < entries.size(); ++k)
    pairs_of_group[groups.find(entries[k])].add(model.rest.row(entries[k]).transpose(), targets.row(k).transpose());
  for (const auto& [group, pairs] : pairs_of_group) all.add(pairs);
  const auto add_patches = [&](const std::vector<Average>& patches, const std::vector<int>& rows) {
    for (size_t k = 0; k < patches.size(); ++k)
      all.add(patches[k].of(model.rest).transpose(), targets.row(rows[k]).transpose());
  };
  add_patches(constraints.patches(), constraints.patch_rows());
  add_patches(constraints.anchor_patches(), constraints.anchor_rows());

  std::map<int, std::optional<Matrix3>> rotation_of_group;
  Matrix3 sum = Matrix3::Zero();
  bool has_any = false;
  for (const auto& [group, pairs] : pairs_of_group) {
    rotation_of_group[group] = pairs.rotation();
    if (!rotation_of_group[group]) continue;
    sum += *rotation_of_group[group];
    has_any = true;
  }
  const Matrix3 other =
      has_any ? nearest_rotation(sum, Matrix3::Identity()) : all.rotation().value_or(Matrix3::Identity());

  std::vector<Matrix3> rotations;
  rotations.reserve(targets.rows());
  for (const int v : entries) rotations.push_back(rotation_of_group[groups.find(v)].value_or(other));
  rotations.resize(targets.rows(), other);
  return rotations;
}

}  // namespace arap
