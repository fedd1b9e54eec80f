// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "arap/constraints.h"
#include "arap/types.h"
#include "parallel/workers.h"
#include "sparse/sparse.h"

namespace arap {

/// A linear combination of unknowns: a x = sum_k coefficients[k] x_{indices[k]}. A weighted average has coefficients of
/// sum 1.
struct LinearRow {
  std::vector<int> indices;
  std::vector<double> coefficients;

  [[nodiscard]] Eigen::RowVector3d of(const Positions& x) const;
  [[nodiscard]] double sum() const;
};

/// The average of patch p, in the order of its vertices.
/// @param counts  whether a vertex is part of it
[[nodiscard]] LinearRow average_of(const Patches& patches, int p, const std::function<bool(int)>& counts);

/// Linear constraints a_r x = t_r on the unknowns of a model, as many as one likes, each of a few unknowns. A soft row
/// adds 1/2 w_r |a_r x - t_r|^2 to the energy; a hard row is met. Rows may repeat or contradict each other: soft ones
/// then meet where their energy is least, hard ones where the sum of squared gaps is, each in units of its stiffness.
struct LinearRows {
  static constexpr double kHard = std::numeric_limits<double>::infinity();

  std::vector<LinearRow> rows;
  std::vector<double> weights;  ///< (n_rows,) w_r in units of K, or kHard

  [[nodiscard]] int size() const { return static_cast<int>(rows.size()); }
  [[nodiscard]] bool empty() const { return rows.empty(); }
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> weight_vector() const { return {weights.data(), size()}; }
  void add(LinearRow row, double weight) {
    rows.push_back(std::move(row));
    weights.push_back(weight);
  }
  /// Throws InvalidInput that names the row: an index out of [0, n_unknowns), a coefficient that is not finite, none
  /// other than 0, or a weight that is not above 0.
  void validate(int n_unknowns) const;
};

/// The matrix of linear rows, to multiply with.
class RowMatrix {
 public:
  RowMatrix() = default;
  RowMatrix(const LinearRows& rows, int n_unknowns);

  [[nodiscard]] bool empty() const { return by_row_.rows() == 0; }
  [[nodiscard]] int size() const { return static_cast<int>(by_row_.rows()); }

  /// y = A x, (n_rows, 3).
  void multiply(const Positions& x, Positions& y, const Workers& workers) const;
  /// targets - A x, (n_rows, 3).
  [[nodiscard]] Positions gaps(const Positions& targets, const Positions& x, const Workers& workers) const;
  /// x += A^T y.
  void add_transposed(const Positions& y, Positions& x, const Workers& workers) const;
  /// A^T diag(weights) A.
  [[nodiscard]] SparseMatrix normal_matrix(const Eigen::VectorXd& weights) const;
  /// Calls use(row, coefficient) for each row that has this unknown.
  template <class Use>
  void for_rows_of(int unknown, const Use& use) const {
    for (SparseMatrix::InnerIterator it(by_unknown_, unknown); it; ++it) use(static_cast<int>(it.row()), it.value());
  }
  /// The same for the unknowns of a row.
  template <class Use>
  void for_unknowns_of(int row, const Use& use) const {
    for (ByRow::InnerIterator it(by_row_, row); it; ++it) use(static_cast<int>(it.col()), it.value());
  }

 private:
  using ByRow = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

  ByRow by_row_;
  SparseMatrix by_unknown_;
};

/// The weight at which each row pulls as strongly as K does at its unknowns; infinite if K holds none of them.
[[nodiscard]] Eigen::VectorXd row_stiffness(const RowMatrix& rows, const SparseMatrix& K);

}  // namespace arap
