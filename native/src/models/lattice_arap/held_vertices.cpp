// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/held_vertices.h"

#include <algorithm>
#include <map>
#include <utility>

#include "dense/small_matrices.h"

namespace arap {

namespace {

double strength_of(const ConstraintSet& set, size_t k) {
  const double s = set.strengths.empty() ? 1.0 : set.strengths[k];
  return s < 1 ? std::min(kHardStrength, s / (1 - s)) : kHardStrength;
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
  const auto [values, vectors] = symmetric_eigen(Eigen::MatrixXd(normal));
  // Weaker rows than that hold nothing that shows, and would be most of the rows.
  const double least = 1e-5 * values[kControlPoints - 1];
  const auto n_rows = (values.array() > least).count();
  const Lattice::ControlPoints& points = lattice_->control_points(piece);
  for (auto e = kControlPoints - n_rows; e < kControlPoints; ++e) {
    const auto vector = vectors.col(e);
    rows_.add({{points.begin(), points.end()}, {vector.begin(), vector.end()}}, 2 * values[e]);
    sources_.push_back(held.front().source);
  }
  pieces_.push_back(
      {std::move(held), values.tail(n_rows).cwiseInverse().asDiagonal() * vectors.rightCols(n_rows).transpose()});
}

void HeldVertices::add_patch(const ConstraintSet& set, int p) {
  std::map<int, double> row;
  double sum = 0;
  for (int k = set.patches.offsets[p]; k < set.patches.offsets[p + 1]; ++k) {
    const int vertex = set.patches.vertices[k];
    if (!(set.patches.weights[k] > 0) || lattice_->piece_of_vertex()[vertex] < 0) continue;
    const auto [indices, coefficients] = lattice_->row(vertex);
    for (size_t i = 0; i < indices.size(); ++i) row[indices[i]] += set.patches.weights[k] * coefficients[i];
    sum += set.patches.weights[k];
  }
  if (!(sum > 0)) return;  // all of it is on sheets
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

}  // namespace arap
