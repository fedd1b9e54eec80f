// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/poisson_editing/face_forces.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include "geometry/rotation_vectors.h"
#include "parallel/parallel.h"

namespace arap {

/// Reads the triangles and ties of one face after the other.
class FaceForces::Reader {
 public:
  Reader(FaceForces& forces, const PolygonMesh& mesh, const Triangulation& triangulation)
      : forces_(forces), rest_(mesh.positions()), triangulation_(triangulation), corner_of_(mesh.n_vertices(), -1) {}

  void read(int f, std::span<const int> face) {
    for (size_t k = 0; k < face.size(); ++k) corner_of_[face[k]] = forces_.offsets_[f] + static_cast<int>(k);
    const std::vector<Triangle>& triangles = triangulation_.triangles;
    const std::vector<Tie>& ties = triangulation_.ties;
    while (next_triangle_ < triangles.size() && triangles[next_triangle_].face == f) add(triangles[next_triangle_++]);
    while (next_tie_ < ties.size() && ties[next_tie_].face == f) add(ties[next_tie_++]);
  }

 private:
  template <class Item>
  void add(const Item& item) {
    add_rest_vectors(item, rest_, [&](int vertex, const Eigen::RowVector3d& q) {
      forces_.rest_vectors_.row(corner_of_[vertex]) += q;
    });
  }

  FaceForces& forces_;
  const Positions& rest_;
  const Triangulation& triangulation_;
  std::vector<int> corner_of_;  ///< of a vertex, in the face that was read last
  size_t next_triangle_ = 0;
  size_t next_tie_ = 0;
};

FaceForces::FaceForces(const PolygonMesh& mesh, const Triangulation& triangulation)
    : rest_vectors_(Positions::Zero(mesh.n_corners(), 3)) {
  offsets_.reserve(static_cast<size_t>(mesh.n_faces()) + 1);
  vertices_.reserve(static_cast<size_t>(mesh.n_corners()));
  Reader reader(*this, mesh, triangulation);
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    vertices_.insert(vertices_.end(), face.begin(), face.end());
    reader.read(f, face);
    offsets_.push_back(static_cast<int>(vertices_.size()));
  }
}

void FaceForces::renumber(const std::vector<int>& new_of_old) {
  const auto n_vertices = static_cast<int>(new_of_old.size());
  for (int& v : vertices_) v = new_of_old[v];
  // In the order of their vertices, faces find what they read near what the last one has read.
  const Grouped by_lowest(n_vertices, [&](const auto& add) {
    for (int f = 0; f < n_faces(); ++f)
      add(*std::min_element(vertices_.begin() + offsets_[f], vertices_.begin() + offsets_[f + 1]), f);
  });
  FaceForces sorted;
  sorted.offsets_.reserve(offsets_.size());
  sorted.vertices_.reserve(vertices_.size());
  sorted.rest_vectors_.resize(rest_vectors_.rows(), 3);
  for (int v = 0; v < n_vertices; ++v)
    for (const int f : by_lowest.of(v)) {
      for (int k = offsets_[f]; k < offsets_[f + 1]; ++k) {
        sorted.rest_vectors_.row(std::ssize(sorted.vertices_)) = rest_vectors_.row(k);
        sorted.vertices_.push_back(vertices_[k]);
      }
      sorted.offsets_.push_back(static_cast<int>(sorted.vertices_.size()));
    }
  sorted.corners_ = Grouped(n_vertices, [&](const auto& add) {
    for (size_t k = 0; k < sorted.vertices_.size(); ++k) add(sorted.vertices_[k], static_cast<int>(k));
  });
  *this = std::move(sorted);
}

Matrix3 FaceForces::change_of(int f, const Positions& turns, const Positions& log_scales) const {
  const double share = 1.0 / (offsets_[f + 1] - offsets_[f]);
  Vector3 turn = Vector3::Zero();
  for (int k = offsets_[f]; k < offsets_[f + 1]; ++k) turn += turns.row(vertices_[k]).transpose();
  Matrix3 change = rotation_less_identity(share * turn);
  if (log_scales.rows() > 0) {
    double log_scale = 0;
    for (int k = offsets_[f]; k < offsets_[f + 1]; ++k) log_scale += log_scales(vertices_[k], 0);
    change *= std::exp(share * log_scale);
    change.diagonal().array() += std::expm1(share * log_scale);
  }
  return change;
}

Positions FaceForces::find(const Positions& turns, const Positions& log_scales, const Workers& workers) const {
  Positions of_corners(rest_vectors_.rows(), 3);
  parallel_for(workers, n_faces(), [&](int begin, int end) {
    for (int f = begin; f < end; ++f) {
      const Matrix3 change = change_of(f, turns, log_scales);
      for (int k = offsets_[f]; k < offsets_[f + 1]; ++k)
        of_corners.row(k).transpose().noalias() = change * rest_vectors_.row(k).transpose();
    }
  });
  Positions forces(turns.rows(), 3);
  parallel_for(workers, static_cast<int>(turns.rows()), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (const int k : corners_.of(v)) sum += of_corners.row(k);
      forces.row(v) = sum;
    }
  });
  return forces;
}

}  // namespace arap
