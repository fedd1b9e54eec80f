// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "cholesky/linear_solver.h"
#include "cholesky/preconditioned_cg.h"
#include "parallel/workers.h"
#include "sparse/sparse.h"

namespace arap {

/// A weighted average of unknowns; the weights sum to 1.
struct Average {
  std::vector<int> indices;
  std::vector<double> weights;

  [[nodiscard]] Eigen::RowVector3d of(const Positions& x) const;
};

/// Targets minus averages of x, (n_averages, 3).
[[nodiscard]] Positions gaps_to(Positions targets, const std::vector<Average>& averages, const Positions& x);

/// How a minimizer follows the targets of its averages: x + steps * change.
struct Responses {
  Eigen::MatrixXd steps;      ///< (n, n_averages), 0 at fixed unknowns
  Eigen::MatrixXd stiffness;  ///< (n_averages, n_averages): steps^T A steps
};

/// Minimizes 1/2 <x, A x> - <b, x> with A = K + a diagonal for soft constraints, some unknowns fixed (their rows and
/// columns are erased) and some averages held at targets (Lagrange multipliers). Factorized once; then any b, fixed
/// values and targets. Works on residuals: x + correct(b - A x) is the minimizer, so that the fixed point of an
/// iteration does not depend on the accuracy of the factor.
///
/// Where averages alone hold a component, K is singular there: one unknown of it is grounded by an extra diagonal entry
/// in the factor, and the small dense system of the multipliers takes the grounding out again.
class ConstrainedSystem {
 public:
  /// @param solver         made for the pattern of K
  /// @param K              (n, n) symmetric positive semi-definite, stored whole, with its diagonal
  /// @param components     (n,) its connected_components()
  /// @param is_fixed       (n,)
  /// @param soft_diagonal  (n,) >= 0
  /// Throws SolverError, or Cancelled.
  ConstrainedSystem(const LinearSolver& solver, const SparseMatrix& K, const std::vector<int>& components,
                    std::vector<char> is_fixed, const Eigen::VectorXd& soft_diagonal, std::vector<Average> averages,
                    const Progress& progress, Workers workers = Workers(1));

  /// A, without erasing and grounding.
  [[nodiscard]] const SparseMatrix& matrix() const { return matrix_; }
  [[nodiscard]] const Factorization& factor() const { return *factor_; }
  [[nodiscard]] const std::vector<Average>& averages() const { return averages_; }

  [[nodiscard]] Responses responses() const;

  /// Sets `correction` to that of x for `residual` = b - A x, as exact as the factor is; 0 at fixed unknowns. The
  /// averages meet their targets exactly in every case.
  /// @param gaps         (n_averages, 3) target minus average of x
  /// @param multipliers  (n_averages, 3) of the last correction, or empty; set: A x + sum_k a_k multipliers_k = b at
  ///                     the corrected x. To start from the last ones makes the correction vanish at the minimizer.
  /// @param correction   may be the residual
  void correct(const Positions& residual, const Positions& gaps, Positions& multipliers, Positions& correction) const;

  /// Replaces the residual by the same to a part of itself, at once: see solve_with_cg().
  void correct_to(double accuracy, Positions& residual, const Positions& gaps) const;

 private:
  /// One unknown of each component that no fixed unknown and no soft constraint holds.
  [[nodiscard]] std::vector<int> find_unheld(const std::vector<int>& components,
                                             const Eigen::VectorXd& soft_diagonal) const;
  void prepare_dense_part(const Progress& progress);
  void solve_columns(const Progress& progress);
  void erase_fixed(Positions& x) const;
  /// The factorized matrix times x.
  void multiply_held(const Positions& x, Positions& result) const;
  /// Completes x = factor^-1 residual by the multipliers; returns their change.
  [[nodiscard]] Positions meet_averages(Positions& x, const Positions& gaps) const;

  SparseMatrix matrix_;
  Workers workers_;
  std::vector<char> is_fixed_;
  std::vector<Average> averages_;
  std::vector<int> grounded_;
  std::vector<double> grounding_;  ///< added to the diagonal of A in the factor, of each grounded unknown
  std::unique_ptr<Factorization> factor_;
  /// Columns: the averages, then the grounded unknowns (with sign), restricted to free unknowns.
  std::vector<Average> columns_;
  Eigen::MatrixXd column_solutions_;  ///< factor^-1 columns, (n, n_columns)
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> dense_;
};

}  // namespace arap
