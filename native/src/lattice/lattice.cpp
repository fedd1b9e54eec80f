// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/lattice.h"

#include <utility>

#include "base/available_memory.h"
#include "base/eigen_compat.h"
#include "kernels/kernels.h"
#include "parallel/parallel.h"

namespace arap {

Lattice::Lattice(const PolygonMesh& mesh, double cube_size, const MeterPart& meter, int most_hollow)
    : cube_size_(cube_size),
      pieces_(mesh, cube_size, meter, most_hollow),
      places_(mesh.n_vertices(), Eigen::Vector3f::Zero()) {
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (const int piece = piece_of_vertex()[v]; piece >= 0)
      places_[v] = ((mesh.positions().row(v) - pieces_.lowest_corner(piece)) / cube_size).transpose().cast<float>();
  name_control_points();
}

void Lattice::name_control_points() {
  constexpr double kBytesPerPiece = 2000;  // if none shares its control points
  require_memory(kBytesPerPiece * n_pieces(), "the lattice of this mesh");
  const std::vector<int> numbers = pieces_.shared_points(3);
  control_points_.resize(n_pieces());
  std::vector<Eigen::RowVector3d> rest;
  for (int piece = 0; piece < n_pieces(); ++piece)
    for (int k = 0; k < kControlPoints; ++k) {
      const int c = numbers[kControlPoints * piece + k];
      control_points_[piece][k] = c;
      if (c < static_cast<int>(rest.size())) continue;
      const CubeGrid::Cube steps{k / 9, k / 3 % 3, k % 3};
      rest.emplace_back(pieces_.lowest_corner(piece) +
                        cube_size_ * (Eigen::RowVector3d(steps[0], steps[1], steps[2]).array() - 0.5).matrix());
      parts_.push_back(pieces_.part(piece));
    }
  rest_.resize(static_cast<Eigen::Index>(rest.size()), 3);
  for (size_t c = 0; c < rest.size(); ++c) rest_.row(static_cast<Eigen::Index>(c)) = rest[c];
}

Lattice::AxisWeights Lattice::axis_weights(const Eigen::Vector3d& place) {
  return {spline_weights(place[0]), spline_weights(place[1]), spline_weights(place[2])};
}

Lattice::Weights Lattice::weights(int vertex) const { return weights_at(places_[vertex].cast<double>()); }

Lattice::Weights Lattice::weights_at(const Eigen::Vector3d& place) {
  const auto [x, y, z] = axis_weights(place);
  Weights result;
  double* next = result.data();
  for (const double of_x : x)
    for (const double of_y : y)
      for (const double of_z : z) *next++ = of_x * of_y * of_z;
  return result;
}

LinearRow Lattice::row(int vertex) const {
  const ControlPoints& points = control_points_[piece_of_vertex()[vertex]];
  const auto phi = weights(vertex);
  return {{points.begin(), points.end()}, {phi.begin(), phi.end()}};
}

Positions Lattice::corners(const Positions& control_points) const {
  constexpr int kCorners = 8;
  Eigen::Matrix<double, kCorners, kControlPoints> weights;
  for (int k = 0; k < kCorners; ++k)
    weights.row(k) = weights_at(Eigen::Vector3d(k >> 2, k >> 1 & 1, k & 1)).transpose();
  Positions result(Eigen::Index{kCorners} * n_pieces(), 3);
  for (int piece = 0; piece < n_pieces(); ++piece)
    result.middleRows<kCorners>(Eigen::Index{kCorners} * piece) = weights * control_points(control_points_[piece], all);
  return result;
}

void Lattice::renumber(const std::vector<int>& new_of_old) {
  Positions rest(rest_.rows(), 3);
  std::vector<int> parts(parts_.size());
  for (size_t c = 0; c < parts_.size(); ++c) {
    rest.row(new_of_old[c]) = rest_.row(static_cast<Eigen::Index>(c));
    parts[new_of_old[c]] = parts_[c];
  }
  rest_ = std::move(rest);
  parts_ = std::move(parts);
  for (ControlPoints& points : control_points_)
    for (int& c : points) c = new_of_old[c];
}

void Lattice::embed(const Positions& control_points, const Workers& workers, Positions& points) const {
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> padded(control_points.rows(), 4);
  padded << control_points, Eigen::VectorXd::Zero(control_points.rows());
  const EmbeddingView vertices{piece_of_vertex().data(), places_.data()->data(), control_points_.data()->data()};
  const LatticeKernels& kernel = kernels(isa_).lattice;
  parallel_for<1024>(workers, static_cast<int>(places_.size()),
                     [&](int begin, int end) { kernel.embed(vertices, padded.data(), points.data(), begin, end); });
}

}  // namespace arap
