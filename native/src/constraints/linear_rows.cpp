// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/linear_rows.h"

#include <cmath>
#include <map>
#include <numeric>

#include "arap/error.h"
#include "base/format_message.h"
#include "parallel/parallel.h"

namespace arap {

Eigen::RowVector3d LinearRow::of(const Positions& x) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (size_t k = 0; k < indices.size(); ++k) sum += coefficients[k] * x.row(indices[k]);
  return sum;
}

double LinearRow::sum() const { return std::accumulate(coefficients.begin(), coefficients.end(), 0.0); }

LinearRow average_of(const Patches& patches, int p, const std::function<bool(int)>& counts) {
  std::map<int, double> weight_of_vertex;
  double sum = 0;
  for (int k = patches.offsets[p]; k < patches.offsets[p + 1]; ++k) {
    if (!(patches.weights[k] > 0) || !counts(patches.vertices[k])) continue;
    weight_of_vertex[patches.vertices[k]] += patches.weights[k];
    sum += patches.weights[k];
  }
  LinearRow average;
  for (const auto& [v, weight] : weight_of_vertex) {
    average.indices.push_back(v);
    average.coefficients.push_back(weight / sum);
  }
  return average;
}

void LinearRows::validate(int n_unknowns) const {
  for (int r = 0; r < size(); ++r) {
    if (!(weights[r] > 0)) throw InvalidInput(text("weight of row ", r, " is ", weights[r], ", must be above 0"));
    const auto& [indices, coefficients] = rows[r];
    bool has_entry = false;
    for (size_t k = 0; k < indices.size(); ++k) {
      if (indices[k] < 0 || indices[k] >= n_unknowns)
        throw InvalidInput(
            text("row ", r, " names unknown ", indices[k], ", but there are unknowns 0 to ", n_unknowns - 1));
      if (!std::isfinite(coefficients[k]))
        throw InvalidInput(text("row ", r, ": coefficient of unknown ", indices[k], " is not finite"));
      has_entry = has_entry || coefficients[k] != 0;
    }
    if (!has_entry) throw InvalidInput(text("row ", r, " has no coefficient other than 0"));
  }
}

RowMatrix::RowMatrix(const LinearRows& rows, int n_unknowns)
    : by_row_(rows.size(), n_unknowns), by_unknown_(rows.size(), n_unknowns) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int r = 0; r < rows.size(); ++r)
    for (size_t k = 0; k < rows.rows[r].indices.size(); ++k)
      entries.emplace_back(r, rows.rows[r].indices[k], rows.rows[r].coefficients[k]);
  by_row_.setFromTriplets(entries.begin(), entries.end());
  by_unknown_ = by_row_;
}

void RowMatrix::multiply(const Positions& x, Positions& y, const Workers& workers) const {
  y.resize(size(), 3);
  parallel_for(workers, size(), [&](int begin, int end) {
    for (int r = begin; r < end; ++r) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for_unknowns_of(r, [&](int unknown, double coefficient) { sum += coefficient * x.row(unknown); });
      y.row(r) = sum;
    }
  });
}

Positions RowMatrix::gaps(const Positions& targets, const Positions& x, const Workers& workers) const {
  Positions reached;
  multiply(x, reached, workers);
  return targets - reached;
}

void RowMatrix::add_transposed(const Positions& y, Positions& x, const Workers& workers) const {
  if (empty()) return;
  parallel_for(workers, static_cast<int>(x.rows()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for_rows_of(i, [&](int row, double coefficient) { sum += coefficient * y.row(row); });
      x.row(i) += sum;
    }
  });
}

SparseMatrix RowMatrix::normal_matrix(const Eigen::VectorXd& weights) const {
  const SparseMatrix weighted = weights.asDiagonal() * by_unknown_;
  return SparseMatrix(by_unknown_.transpose()) * weighted;
}

Eigen::VectorXd row_stiffness(const RowMatrix& rows, const SparseMatrix& K) {
  const Eigen::VectorXd diagonal = K.diagonal();
  Eigen::VectorXd stiffness(rows.size());
  for (int r = 0; r < rows.size(); ++r) {
    double compliance = 0;
    rows.for_unknowns_of(r, [&](int i, double a) {
      if (diagonal[i] > 0) compliance += a * a / diagonal[i];
    });
    stiffness[r] = compliance > 0 ? 1 / compliance : std::numeric_limits<double>::infinity();
  }
  return stiffness;
}

}  // namespace arap
