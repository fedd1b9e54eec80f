// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/held_vertices.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <functional>
#include <map>
#include <queue>
#include <span>
#include <tuple>
#include <utility>

#include "base/grouped.h"

namespace arap {

namespace {

/// Strength of a hard vertex: what it leaves is a thousandth of the diagonal at the most, and the system stays easy.
constexpr double kHardStrength = 100;

double strength_of(const ConstraintSet& set, size_t k) {
  const double s = set.strengths.empty() ? 1.0 : set.strengths[k];
  return s < 1 ? std::min(kHardStrength, s / (1 - s)) : kHardStrength;
}

/// Nothing pulls a loose vertex from its target.
bool is_exact(const PolygonMesh& mesh, const ConstraintSet& set, size_t k) {
  return set.strengths.empty() || set.strengths[k] >= 1 - 1e-9 ||
         (mesh.part_of_vertex()[set.vertices[k]] < 0 && set.strengths[k] > 0);
}

/// The vertices that each has an edge to, once for each side of a face.
Grouped neighbours_of(const PolygonMesh& mesh) {
  return {mesh.n_vertices(), [&](const auto& add) {
            for (int f = 0; f < mesh.n_faces(); ++f) {
              const std::span<const int> face = mesh.face(f);
              for (size_t k = 0; k < face.size(); ++k) {
                const int next = face[(k + 1) % face.size()];
                add(face[k], next);
                add(next, face[k]);
              }
            }
          }};
}

}  // namespace

HeldVertices::HeldVertices(const Lattice& lattice, const std::vector<double>& areas, const ConstraintSet& set)
    : lattice_(&lattice) {
  std::map<int, std::vector<Held>> by_piece;
  for (size_t k = 0; k < set.vertices.size(); ++k)
    if (const int piece = lattice.piece_of_vertex()[set.vertices[k]]; piece >= 0 && strength_of(set, k) > 0)
      by_piece[piece].push_back({static_cast<int>(k), set.vertices[k], strength_of(set, k)});
  const double h = lattice.cube_size();
  for (auto& [piece, held] : by_piece) {
    double area = 0;
    for (const Held& one : held) area += areas[one.vertex];
    const double lacking = std::max(0.0, h * h - area) / static_cast<double>(held.size());
    Matrix27 normal = Matrix27::Zero();
    for (Held& one : held) {
      one.weight *= (areas[one.vertex] + lacking) / h;
      const Lattice::Weights phi = lattice.weights(one.vertex);
      normal += one.weight * phi * phi.transpose();
    }
    add_rows(piece, normal, std::move(held));
  }
  for (int p = 0; p < set.patches.size(); ++p) add_patch(set, p);
}

void HeldVertices::add_rows(int piece, const Matrix27& normal, std::vector<Held> held) {
  const Eigen::SelfAdjointEigenSolver<Matrix27> eigen(normal);
  // Weaker rows than that hold nothing that shows, and would be most of the rows.
  const double least = 1e-5 * eigen.eigenvalues()[kControlPoints - 1];
  const auto n_rows = (eigen.eigenvalues().array() > least).count();
  const Lattice::ControlPoints& points = lattice_->control_points(piece);
  for (auto e = kControlPoints - n_rows; e < kControlPoints; ++e) {
    const auto vector = eigen.eigenvectors().col(e);
    rows_.add({{points.begin(), points.end()}, {vector.begin(), vector.end()}}, 2 * eigen.eigenvalues()[e]);
    sources_.push_back(held.front().source);
  }
  pieces_.push_back({std::move(held), eigen.eigenvalues().tail(n_rows).cwiseInverse().asDiagonal() *
                                          eigen.eigenvectors().rightCols(n_rows).transpose()});
}

void HeldVertices::add_patch(const ConstraintSet& set, int p) {
  std::map<int, double> row;
  double sum = 0;
  for (int k = set.patches.offsets[p]; k < set.patches.offsets[p + 1]; ++k) {
    if (!(set.patches.weights[k] > 0)) continue;
    const auto [indices, coefficients] = lattice_->row(set.patches.vertices[k]);
    for (size_t i = 0; i < indices.size(); ++i) row[indices[i]] += set.patches.weights[k] * coefficients[i];
    sum += set.patches.weights[k];
  }
  LinearRow average;
  for (const auto& [index, coefficient] : row) {
    average.indices.push_back(index);
    average.coefficients.push_back(coefficient / sum);
  }
  rows_.add(std::move(average), LinearRows::kHard);
  sources_.push_back(static_cast<int>(set.vertices.size()) + p);
}

Positions HeldVertices::targets(const Positions& of_set) const {
  Positions result(rows_.size(), 3);
  Eigen::Index row = 0;
  for (const Piece& piece : pieces_) {
    Eigen::Matrix<double, kControlPoints, 3> sum = Eigen::Matrix<double, kControlPoints, 3>::Zero();
    for (const Held& one : piece.held) sum += one.weight * lattice_->weights(one.vertex) * of_set.row(one.source);
    result.middleRows(row, piece.to_rows.rows()) = piece.to_rows * sum;
    row += piece.to_rows.rows();
  }
  for (; row < result.rows(); ++row) result.row(row) = of_set.row(sources_[row]);
  return result;
}

ExactVertices::ExactVertices(const PolygonMesh& mesh, const ConstraintSet& set, double reach) {
  std::map<int, int> held_of_vertex;
  for (size_t k = 0; k < set.vertices.size(); ++k) {
    if (!is_exact(mesh, set, k)) continue;
    const auto [found, is_new] = held_of_vertex.emplace(set.vertices[k], static_cast<int>(held_.size()));
    if (is_new) held_.push_back({set.vertices[k], {}});
    held_[found->second].targets.push_back(static_cast<int>(k));
  }
  // Dijkstra's algorithm from all of them.
  struct Reached {
    double distance;
    int vertex;
    int held;
    bool operator>(const Reached& other) const {
      return std::tie(distance, vertex, held) > std::tie(other.distance, other.vertex, other.held);
    }
  };
  const Grouped neighbours = neighbours_of(mesh);
  std::vector<char> is_done(mesh.n_vertices(), 0);
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  const auto go_on = [&](const Reached& from) {
    for (const int v : neighbours.of(from.vertex)) {
      const double distance = from.distance + (mesh.positions().row(v) - mesh.positions().row(from.vertex)).norm();
      if (is_done[v] == 0 && distance < reach) queue.push({distance, v, from.held});
    }
  };
  for (const Held& held : held_) is_done[held.vertex] = 1;
  for (size_t k = 0; k < held_.size(); ++k) go_on({0, held_[k].vertex, static_cast<int>(k)});
  while (!queue.empty()) {
    const Reached next = queue.top();
    queue.pop();
    if (is_done[next.vertex] != 0) continue;
    is_done[next.vertex] = 1;
    const double part = next.distance / reach;
    followers_.push_back({next.vertex, next.held, (1 - part * part) * (1 - part * part)});
    go_on(next);
  }
}

void ExactVertices::apply(const Positions& targets, Positions& points) const {
  Positions left(held_.size(), 3);
  for (size_t k = 0; k < held_.size(); ++k) {
    Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
    for (const int t : held_[k].targets) mean += targets.row(t) / static_cast<double>(held_[k].targets.size());
    left.row(static_cast<Eigen::Index>(k)) = mean - points.row(held_[k].vertex);
    points.row(held_[k].vertex) = mean;
  }
  for (const Follower& follower : followers_) points.row(follower.vertex) += follower.share * left.row(follower.held);
}

}  // namespace arap
