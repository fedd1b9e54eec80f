// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/reference.h"

#include <algorithm>
#include <map>
#include <utility>

#include "base/eigen_compat.h"
#include "support/dense.h"

namespace arap_test {

namespace {

using arap::all;
using Eigen::Index;
using Eigen::MatrixXd;

Vector3 edge(const Positions& p, int a, int b) { return (p.row(a) - p.row(b)).transpose(); }

}  // namespace

Reference::Reference(const MeshData& mesh, arap::Energy energy, arap::EdgeWeights weights,
                     std::vector<double> stiffness)
    : n_(mesh.n_vertices()), n_cells_(n_), diagonal_(mesh.diagonal()), rest_(mesh.positions()) {
  if (stiffness.empty()) stiffness.assign(static_cast<size_t>(n_), 1.0);
  cut_into_triangles(mesh, weights);
  if (energy == arap::Energy::kSpokes)
    assemble_spokes(stiffness);
  else
    assemble_spokes_and_rims(stiffness);
}

void Reference::cut_into_triangles(const MeshData& mesh, arap::EdgeWeights weights) {
  for (const auto& face : mesh.faces) {
    const size_t n = face.size();
    // An n-gon is the average of the fans from each of its n corners.
    for (size_t corner = 0; corner < n; ++corner) {
      for (size_t k = 1; k + 1 < n; ++k) {
        Triangle t{{face[corner], face[(corner + k) % n], face[(corner + k + 1) % n]}, {1, 1, 1}, 1.0 / double(n)};
        double longest = 0;
        double twice_area = 0;
        for (size_t c = 0; c < 3; ++c) {
          const Vector3 u = edge(rest_, t.vertices[(c + 1) % 3], t.vertices[c]);
          const Vector3 v = edge(rest_, t.vertices[(c + 2) % 3], t.vertices[c]);
          longest = std::max(longest, u.norm());
          twice_area = u.cross(v).norm();
          if (weights == arap::EdgeWeights::kCotangent) t.cotangents[c] = u.dot(v) / twice_area;
        }
        const bool is_degenerate = twice_area < 1e-4 * longest * longest;
        if (!is_degenerate || weights == arap::EdgeWeights::kUniform) triangles_.push_back(t);
      }
    }
  }
}

/// [SA07] Eq. (7): E = sum_i sum_j w_ij |e'_ij - R_i e_ij|^2, w_ij = 1/2 sum of the cotangents opposite to ij, each
/// clamped at 0.
void Reference::assemble_spokes(const std::vector<double>& stiffness) {
  std::map<std::pair<int, int>, double> w;
  for (const Triangle& t : triangles_) {
    for (size_t c = 0; c < 3; ++c) {
      const int i = t.vertices[(c + 1) % 3];
      const int j = t.vertices[(c + 2) % 3];
      const double half = t.weight * std::max(t.cotangents[c], 0.0) / 2;
      w[{i, j}] += half;
      w[{j, i}] += half;
    }
  }
  for (const auto& [ij, w_ij] : w) add_term(ij.first, ij.first, ij.second, stiffness[ij.first] * w_ij);
}

/// [CPSS10]: E = 1/3 sum_i sum_{f at i} sum_{ab in f} (cot_ab / 2) |e'_ab - R_i e_ab|^2.
void Reference::assemble_spokes_and_rims(const std::vector<double>& stiffness) {
  for (const Triangle& t : triangles_)
    for (const int i : t.vertices)
      for (size_t c = 0; c < 3; ++c)
        add_term(i, t.vertices[(c + 1) % 3], t.vertices[(c + 2) % 3],
                 stiffness[i] * t.weight * t.cotangents[c] / 2 / 3);
}

void Reference::share_rotations(const MatrixXd& weights) {
  const std::vector<Term> of_vertices = std::move(terms_);
  terms_.clear();
  n_cells_ = static_cast<int>(weights.cols());
  for (const auto& [j, a, b, weight] : of_vertices)
    for (int c = 0; c < n_cells_; ++c)
      if (weights(j, c) > 0) add_term(c, a, b, weights(j, c) * weight);
}

void Reference::add_term(int cell, int a, int b, double weight) { terms_.push_back({cell, a, b, weight}); }

double Reference::energy(const Positions& positions, const std::vector<Matrix3>& rotations) const {
  double sum = 0;
  for (const auto& [cell, a, b, weight] : terms_)
    sum += weight * (edge(positions, a, b) - rotations[cell] * edge(rest_, a, b)).squaredNorm();
  return sum;
}

double Reference::energy(const Positions& positions) const { return energy(positions, rotations(positions)); }

double Reference::soft_energy(const arap::ConstraintSet& constraints, const Positions& targets,
                              const Positions& positions) const {
  const MatrixXd K = matrix();
  double sum = 0;
  for (size_t k = 0; k < constraints.vertices.size(); ++k) {
    const double s = constraints.strengths[k];
    const int i = constraints.vertices[k];
    if (s < 1) sum += K(i, i) * s / (1 - s) * (positions.row(i) - targets.row(static_cast<Index>(k))).squaredNorm();
  }
  return sum;
}

std::vector<Matrix3> Reference::rotations(const Positions& positions) const {
  std::vector<Matrix3> S(static_cast<size_t>(n_cells_), Matrix3::Zero());
  for (const auto& [cell, a, b, weight] : terms_)
    S[cell] += weight * edge(positions, a, b) * edge(rest_, a, b).transpose();
  std::vector<Matrix3> R;
  R.reserve(S.size());
  for (const Matrix3& covariance : S) R.push_back(best_rotation(covariance));
  return R;
}

Positions Reference::gradient(const Positions& positions) const { return gradient(positions, rotations(positions)); }

Positions Reference::gradient(const Positions& positions, const std::vector<Matrix3>& rotations) const {
  Positions result = Positions::Zero(n_, 3);
  for (const auto& [cell, a, b, weight] : terms_) {
    const Vector3 g = 2 * weight * (edge(positions, a, b) - rotations[cell] * edge(rest_, a, b));
    result.row(a) += g.transpose();
    result.row(b) -= g.transpose();
  }
  return result;
}

MatrixXd Reference::matrix() const {
  MatrixXd K = MatrixXd::Zero(n_, n_);
  for (const auto& [cell, a, b, weight] : terms_) {
    K(a, a) += 2 * weight;
    K(b, b) += 2 * weight;
    K(a, b) -= 2 * weight;
    K(b, a) -= 2 * weight;
  }
  return K;
}

Positions Reference::right_hand_side(const std::vector<Matrix3>& rotations) const {
  Positions result = Positions::Zero(n_, 3);
  for (const auto& [cell, a, b, weight] : terms_) {
    const Vector3 g = 2 * weight * rotations[cell] * edge(rest_, a, b);
    result.row(a) += g.transpose();
    result.row(b) -= g.transpose();
  }
  return result;
}

Positions Reference::rest_guess(const arap::ConstraintSet& constraints, const Positions& targets) const {
  Positions start = rest_;
  for (size_t k = 0; k < constraints.vertices.size(); ++k)
    if (constraints.strengths[k] == 1) start.row(constraints.vertices[k]) = targets.row(static_cast<Index>(k));
  return start;
}

Positions Reference::laplacian_guess(const arap::ConstraintSet& constraints, const Positions& targets) const {
  Positions guess = rest_guess(constraints, targets);
  std::vector<int> is_free(static_cast<size_t>(n_), 1);
  for (size_t k = 0; k < constraints.vertices.size(); ++k)
    if (constraints.strengths[k] == 1) is_free[constraints.vertices[k]] = 0;
  std::vector<int> free;
  for (int v = 0; v < n_; ++v)
    if (is_free[v] != 0) free.push_back(v);
  const MatrixXd K = matrix();
  const MatrixXd change = least_squares(K(all, free), K * (rest_ - guess));
  for (size_t k = 0; k < free.size(); ++k) guess.row(free[k]) += change.row(static_cast<Index>(k));
  return guess;
}

Reference::Solution Reference::solve(const arap::ConstraintSet& constraints, const Positions& targets,
                                     const Positions& start, int max_iterations, double step_tolerance) const {
  MatrixXd K = matrix();
  Positions soft = Positions::Zero(n_, 3);
  Positions p = start;
  std::vector<int> is_free(static_cast<size_t>(n_), 1);
  const auto n_vertices = static_cast<Index>(constraints.vertices.size());
  for (Index k = 0; k < n_vertices; ++k) {
    const int i = constraints.vertices[static_cast<size_t>(k)];
    const double s = constraints.strengths[static_cast<size_t>(k)];
    if (s == 1) {
      is_free[i] = 0;
      p.row(i) = targets.row(k);
    } else {
      const double omega = K(i, i) * s / (1 - s);
      K(i, i) += 2 * omega;
      soft.row(i) = 2 * omega * targets.row(k);
    }
  }
  std::vector<int> free;
  std::vector<int> hard;
  for (int v = 0; v < n_; ++v) (is_free[v] != 0 ? free : hard).push_back(v);

  const auto& patches = constraints.patches;
  MatrixXd C = MatrixXd::Zero(patches.size(), n_);
  for (int k = 0; k < patches.size(); ++k) {
    for (int e = patches.offsets[k]; e < patches.offsets[k + 1]; ++e) C(k, patches.vertices[e]) += patches.weights[e];
    C.row(k) /= C.row(k).sum();
  }

  // Rows of hard vertices erased, rows of patches added: the saddle system.
  const auto n_free = static_cast<Index>(free.size());
  MatrixXd A = MatrixXd::Zero(n_free + patches.size(), n_free + patches.size());
  A.topLeftCorner(n_free, n_free) = K(free, free);
  A.topRightCorner(n_free, patches.size()) = C(all, free).transpose();
  A.bottomLeftCorner(patches.size(), n_free) = C(all, free);
  const auto solve = solver_of(A);

  Solution solution;
  const auto total = [&](const Positions& at) { return energy(at) + soft_energy(constraints, targets, at); };
  solution.energies.push_back(total(p));
  const MatrixXd hard_positions = p(hard, all);
  while (solution.iterations < max_iterations) {
    const Positions b = right_hand_side(rotations(p)) + soft;
    MatrixXd right(A.rows(), 3);
    right.topRows(n_free) = b(free, all) - K(free, hard) * hard_positions;
    right.bottomRows(patches.size()) = targets.bottomRows(patches.size()) - C(all, hard) * hard_positions;
    const MatrixXd x = solve(right);
    Positions next = p;
    for (Index k = 0; k < n_free; ++k) next.row(free[static_cast<size_t>(k)]) = x.row(k);
    solution.step = (next - p).rowwise().norm().maxCoeff() / diagonal_;
    p = next;
    ++solution.iterations;
    solution.energies.push_back(total(p));
    if (solution.step <= step_tolerance) break;
  }
  solution.positions = p;
  return solution;
}

}  // namespace arap_test
