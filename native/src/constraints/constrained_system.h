// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "arap/options.h"
#include "cholesky/linear_solver.h"
#include "cholesky/preconditioned_cg.h"
#include "constraints/linear_rows.h"
#include "constraints/stiff_rows.h"
#include "parallel/meter.h"
#include "parallel/workers.h"
#include "sparse/sparse.h"

namespace arap {

/// How a minimizer follows the targets of its averages: x + steps * change.
struct Responses {
  Eigen::MatrixXd steps;      ///< (n, n_averages), 0 at fixed unknowns
  Eigen::MatrixXd stiffness;  ///< (n_averages, n_averages): steps^T A steps
};

/// What holds the unknowns of a system.
struct SystemConstraints {
  std::vector<char> is_fixed;       ///< (n,)
  Eigen::VectorXd soft_diagonal;    ///< (n,) >= 0
  std::vector<LinearRow> averages;  ///< held exactly, each a dense column: for few
  LinearRows soft_rows{};           ///< as many as one likes, each of a few unknowns
  LinearRows stiff_rows{};          ///< the same, with weights far above K
};

/// Minimizes 1/2 <x, A x> - <b, x> + 1/2 sum_r w_r |h_r x - g_r|^2 with A = K + a diagonal for soft unknowns + H^T W H
/// for the soft rows H, and stiff rows h_r; some unknowns are fixed (their rows and columns are erased) and the
/// averages are held at targets (Lagrange multipliers). Factorized once; then any b, fixed values and targets. Works on
/// residuals: x + correct(b - A x) is the minimizer, so that the fixed point of an iteration does not depend on the
/// accuracy of the factor.
///
/// Averages are dense columns, eliminated by their Schur complement; for stiff rows see StiffRows. Rows that leave K's
/// pattern make a new symbolic analysis.
///
/// If only averages, or rows across components, hold a component, K may be singular there: one unknown of it is
/// grounded by an extra diagonal entry in the factor. If rows tell where the component is, the small dense system of
/// the averages takes the grounding out again. If none does (say, all rows there are differences), the grounding stays:
/// no force pulls at it, and the component is not carried away.
class ConstrainedSystem {
 public:
  /// @param solver      made for the pattern of K, of this kind
  /// @param K           (n, n) symmetric positive semi-definite, stored whole, with its diagonal; must outlive the
  /// system
  /// @param components  (n,) its connected_components()
  /// Throws SolverError, or Cancelled.
  ConstrainedSystem(const LinearSolver& solver, LinearSolverKind kind, const SparseMatrix& K,
                    const std::vector<int>& components, SystemConstraints constraints, const Progress& progress,
                    Workers workers = Workers(1));
  ConstrainedSystem(const ConstrainedSystem&) = delete;  // stiff_ refers to factor_
  ConstrainedSystem& operator=(const ConstrainedSystem&) = delete;

  /// result = A x, without erasing and grounding.
  void multiply(const Positions& x, Positions& result) const;
  [[nodiscard]] const Factorization& factor() const { return *factor_; }
  [[nodiscard]] const std::vector<LinearRow>& averages() const { return averages_; }

  [[nodiscard]] Responses responses() const;

  /// Averages and stiff rows, in this order.
  [[nodiscard]] int n_held() const { return static_cast<int>(averages_.size()) + n_stiff(); }

  /// Sets `correction` to that of x for `residual` = b - A x, as exact as the factor is; 0 at fixed unknowns. The
  /// averages meet their targets exactly in every case, the stiff rows to a hundredth of what penalties would leave.
  /// @param gaps         (n_held, 3) target minus what x has
  /// @param multipliers  (n_held, 3) of the last correction, or empty; set: A x + sum_k a_k multipliers_k = b at
  ///                     the corrected x. To start from the last ones makes the correction vanish at the minimizer.
  /// @param correction   may be the residual
  void correct(const Positions& residual, const Positions& gaps, Positions& multipliers, Positions& correction) const;

  /// Replaces the residual by the same to a part of itself, at once: see solve_with_cg().
  void correct_to(double accuracy, Positions& residual, const Positions& gaps) const;

 private:
  void factorize(const LinearSolver& solver, LinearSolverKind kind, const SparseMatrix& K,
                 const SystemConstraints& constraints, const MeterPart& meter);
  void factorize_with_rows(LinearSolverKind kind, const SparseMatrix& K, const SystemConstraints& constraints,
                           const MeterPart& meter);
  /// A with grounding.
  [[nodiscard]] SparseMatrix grounded() const;
  /// One unknown of each component that no fixed unknown, no soft one and no row of its own holds.
  [[nodiscard]] std::vector<int> find_unheld(const std::vector<int>& components,
                                             const SystemConstraints& constraints) const;
  /// Brings the unknowns of components whose places follow from the rows and from the other components to the front;
  /// returns how many they are.
  [[nodiscard]] int sort_by_rows(const std::vector<int>& components, const SystemConstraints& constraints,
                                 std::vector<int>& unheld) const;
  void prepare_dense_part(Meter& meter);
  void solve_columns(Meter& meter);
  [[nodiscard]] int n_stiff() const { return stiff_ == nullptr ? 0 : stiff_->rows().size(); }
  /// Replaces b by x with A x + H^T multipliers = b and what minimizes with the stiff rows H, grounding included.
  void solve_exactly(double accuracy, Positions& b, const Positions& gaps, Positions& multipliers) const;
  void erase_fixed(Positions& x) const;
  /// The factorized matrix times x.
  void multiply_held(const Positions& x, Positions& result) const;
  /// Completes x = factor^-1 residual, with the stiff rows, such that it meets the averages; follows the
  /// multipliers.
  void meet_averages(Positions& x, const Positions& gaps, Positions& multipliers) const;

  const SparseMatrix* matrix_;  ///< A
  SparseMatrix own_matrix_;     ///< if that is not K
  Workers workers_;
  std::vector<char> is_fixed_;
  std::vector<LinearRow> averages_;
  std::vector<int> grounded_;
  int n_released_ = 0;                     ///< of them, the first, whose grounding is taken out
  std::vector<double> grounding_;          ///< added to the diagonal of A in the factor, of each grounded unknown
  std::unique_ptr<Factorization> factor_;  ///< of A with grounding and the penalties of stiff rows
  std::unique_ptr<StiffRows> stiff_;       ///< over factor_; null without stiff rows
  /// Columns: the averages, then the released unknowns (with sign), restricted to free unknowns.
  std::vector<LinearRow> columns_;
  Eigen::MatrixXd column_solutions_;  ///< solutions for the columns as b, (n, n_columns)
  Eigen::MatrixXd column_forces_;     ///< (n_stiff, n_columns) multipliers of the stiff rows there
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> dense_;
};

}  // namespace arap
