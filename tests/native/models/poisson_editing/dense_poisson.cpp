// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/poisson_editing/dense_poisson.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "support/dense.h"

namespace arap_test {

namespace {

Matrix3 rotation_of(const Vector3& turn) {
  return turn.norm() > 0 ? rotation_about(turn.normalized(), turn.norm()) : Matrix3::Identity();
}

}  // namespace

Matrix3 PoissonHandle::rotation() const { return rotation_of(turn); }

DensePoisson::DensePoisson(const MeshData& mesh)
    : faces_(mesh.faces), rest_(mesh.positions()), L_(Eigen::MatrixXd::Zero(mesh.n_vertices(), mesh.n_vertices())) {
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::vector<int>& face = mesh.faces[f];
    const size_t m = face.size();
    for (size_t apex = 0; apex < (m == 3 ? 1 : m); ++apex)
      for (size_t k = 1; k + 1 < m; ++k) {
        Triangle t;
        t.vertices = {face[apex], face[(apex + k) % m], face[(apex + k + 1) % m]};
        t.face = f;
        const auto corner = [&](size_t c) { return Vector3(rest_.row(t.vertices[c % 3])); };
        const Vector3 doubled = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        t.area = doubled.norm() / 2 / (m == 3 ? 1.0 : static_cast<double>(m));
        for (int c = 0; c < 3; ++c)
          t.gradient.col(c) = doubled.normalized().cross(corner(c + 2) - corner(c + 1)) / doubled.norm();
        triangles_.push_back(t);
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b)
            L_(t.vertices[a], t.vertices[b]) += t.area * t.gradient.col(a).dot(t.gradient.col(b));
      }
  }
}

Positions DensePoisson::with_values(const std::vector<PoissonHandle>& handles, const Positions& values,
                                    const Positions& b) const {
  std::vector<char> is_held(static_cast<size_t>(rest_.rows()), 0);
  for (const PoissonHandle& handle : handles)
    for (const int v : handle.vertices) is_held[v] = 1;
  Eigen::MatrixXd A = L_;
  Eigen::MatrixXd right = b;
  for (int v = 0; v < static_cast<int>(rest_.rows()); ++v) {
    if (is_held[v] == 0) continue;
    A.row(v).setZero();
    A(v, v) = 1;
    right.row(v) = values.row(v);
  }
  return solver_of(A)(right);
}

Eigen::MatrixXd DensePoisson::harmonic_weights(const std::vector<PoissonHandle>& handles) const {
  Eigen::MatrixXd weights(rest_.rows(), handles.size());
  for (size_t h = 0; h < handles.size(); ++h) {
    Positions values = Positions::Zero(rest_.rows(), 3);
    for (const int v : handles[h].vertices) values.row(v).setOnes();
    weights.col(static_cast<Eigen::Index>(h)) = with_values(handles, values, 0 * values).col(0);
  }
  return weights;
}

std::vector<double> DensePoisson::distances(const std::vector<int>& sources) const {
  std::vector<double> distance(static_cast<size_t>(rest_.rows()), std::numeric_limits<double>::infinity());
  for (const int v : sources) distance[v] = 0;
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (const Triangle& t : triangles_)
      for (const int a : t.vertices)
        for (const int b : t.vertices) {
          const double further = distance[a] + (rest_.row(a) - rest_.row(b)).norm();
          has_changed = has_changed || further < distance[b];
          distance[b] = std::min(distance[b], further);
        }
  }
  return distance;
}

Eigen::MatrixXd DensePoisson::geodesic_weights(const std::vector<PoissonHandle>& handles) const {
  Eigen::MatrixXd weights(rest_.rows(), handles.size());
  for (size_t h = 0; h < handles.size(); ++h) {
    const std::vector<double> distance = distances(handles[h].vertices);
    for (Eigen::Index v = 0; v < rest_.rows(); ++v)
      weights(v, static_cast<Eigen::Index>(h)) = 1 / std::max(1e-12, distance[v]);
  }
  for (Eigen::Index v = 0; v < rest_.rows(); ++v)
    if (weights.row(v).sum() > 0) weights.row(v) /= weights.row(v).sum();
  return weights;
}

Positions DensePoisson::solve(const std::vector<PoissonHandle>& handles, const Eigen::MatrixXd& weights) const {
  Positions b = Positions::Zero(rest_.rows(), 3);
  for (const Triangle& t : triangles_) {
    Vector3 turn = Vector3::Zero();
    double log_scale = 0;
    const std::vector<int>& face = faces_[t.face];
    for (const int v : face)
      for (size_t h = 0; h < handles.size(); ++h) {
        const double share = weights(v, static_cast<Eigen::Index>(h)) / static_cast<double>(face.size());
        turn += share * handles[h].turn;
        log_scale += share * std::log(handles[h].scale);
      }
    // Rows of the gradient of positions are derivatives, so its columns turn.
    Matrix3 gradient = Matrix3::Zero();
    for (int c = 0; c < 3; ++c) gradient += t.gradient.col(c) * rest_.row(t.vertices[c]);
    const Matrix3 guide = gradient * (std::exp(log_scale) * rotation_of(turn)).transpose();
    for (int c = 0; c < 3; ++c) b.row(t.vertices[c]) += t.area * t.gradient.col(c).transpose() * guide;
  }
  Positions values = rest_;
  for (const PoissonHandle& handle : handles)
    for (size_t k = 0; k < handle.vertices.size(); ++k)
      values.row(handle.vertices[k]) = handle.targets.row(static_cast<Eigen::Index>(k));
  return with_values(handles, values, b);
}

}  // namespace arap_test
