// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "arap/options.h"
#include "cholesky/linear_solver.h"
#include "constraints/linear_rows.h"
#include "constraints/smallest_change.h"
#include "constraints/stiff_rows.h"
#include "dense/least_squares.h"
#include "parallel/meter.h"
#include "parallel/workers.h"
#include "sparse/sparse.h"

namespace arap {

/// How a minimizer follows the targets of some of its averages while the others stay: x + steps * change.
struct Responses {
  Eigen::MatrixXd steps;      ///< (n, n_moved), 0 at fixed unknowns
  Eigen::MatrixXd stiffness;  ///< (n_moved, n_moved): steps^T A steps
};

/// What holds the unknowns of a system.
struct SystemConstraints {
  std::vector<char> is_fixed;       ///< (n,)
  Eigen::VectorXd soft_diagonal;    ///< (n,) >= 0
  std::vector<LinearRow> averages;  ///< held exactly, joined by a small dense system: for hundreds
  LinearRows soft_rows{};           ///< as many as one likes, each of a few unknowns
  LinearRows stiff_rows{};          ///< the same, with weights far above K
  int n_exact = 0;                  ///< of the stiff ones, the last, which are held exactly, too
};

/// Minimizes 1/2 <x, A x> - <b, x> + 1/2 sum_r w_r |h_r x - g_r|^2 with A = K + a diagonal for soft unknowns + H^T W H
/// for the soft rows H, and stiff rows h_r; some unknowns are fixed (their rows and columns are erased) and the
/// averages are held at targets (Lagrange multipliers). Factorized once; then any b, fixed values and targets. Works on
/// residuals: x + correct(b - A x) is the minimizer, so that the fixed point of an iteration does not depend on the
/// accuracy of the factor.
///
/// Averages are a Border of the factor, eliminated by their Schur complement; for stiff rows see StiffRows. Rows that
/// leave K's pattern make a new symbolic analysis.
///
/// If only averages, or rows across components, hold a component, K may be singular there: one unknown of it is
/// grounded by an extra diagonal entry in the factor. If rows tell where the component is, it is released: the dense
/// system of the averages says how far it moves as one, which the grounding then does not feel. If none does (say, all
/// rows there are differences), the grounding stays: no force pulls at it, and the component is not carried away.
class ConstrainedSystem {
 public:
  /// @param solver      made for the pattern of K
  /// @param factory     as it was made, for other patterns
  /// @param K           (n, n) symmetric positive semi-definite, stored whole, with its diagonal; must outlive the
  /// system
  /// @param components  (n,) its connected_components()
  /// Throws SolverError, or Cancelled.
  ConstrainedSystem(const LinearSolver& solver, const SolverFactory* factory, const SparseMatrix& K,
                    const std::vector<int>& components, SystemConstraints constraints, const Progress& progress,
                    Workers workers = Workers(1));
  ConstrainedSystem(const ConstrainedSystem&) = delete;  // stiff_ refers to factor_
  ConstrainedSystem& operator=(const ConstrainedSystem&) = delete;

  /// result = A x, without erasing and grounding.
  void multiply(const Positions& x, Positions& result) const;
  [[nodiscard]] const Factorization& factor() const { return *factor_; }
  [[nodiscard]] const std::vector<LinearRow>& averages() const { return averages_; }

  [[nodiscard]] Responses responses(const std::vector<int>& moved) const;

  /// Averages and stiff rows, in this order.
  [[nodiscard]] int n_held() const { return static_cast<int>(averages_.size()) + n_stiff(); }

  /// Sets `correction` to that of x for `residual` = b - A x, as exact as the factor is; 0 at fixed unknowns. The
  /// averages and exact rows meet their targets in every case, other stiff rows to a hundredth of what penalties would
  /// leave.
  /// @param gaps         (n_held, 3) target minus what x has
  /// @param multipliers  (n_held, 3) of the last correction, or empty; set: A x + sum_k a_k multipliers_k = b at
  ///                     the corrected x. To start from the last ones makes the correction vanish at the minimizer.
  /// @param correction   may be the residual
  void correct(const Positions& residual, const Positions& gaps, Positions& multipliers, Positions& correction) const;

  /// Replaces the residual by the same to a part of itself, at once: see solve_with_cg().
  void correct_to(double accuracy, Positions& residual, const Positions& gaps) const;

 private:
  void factorize(const LinearSolver& solver, const SolverFactory* factory, const SparseMatrix& K,
                 const SystemConstraints& constraints, const MeterPart& meter);
  void factorize_with_rows(const SolverFactory* factory, const SparseMatrix& K, const SystemConstraints& constraints,
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
  void find_moves(const std::vector<int>& components);
  void prepare_border(const MeterPart& meter);
  [[nodiscard]] int n_stiff() const { return stiff_ == nullptr ? 0 : stiff_->rows().size(); }
  /// Replaces b by the minimizer with the factorized matrix, less the grounding of what is released, in which the
  /// averages have these values, (n_averages, 3). Returns the forces that hold them there.
  Eigen::MatrixX3d solve_held(const Eigen::MatrixX3d& values, Positions& x) const;
  Eigen::MatrixX3d solve_held_at_zero(Positions& x) const;
  /// Brings the averages exactly where they are but for rounding.
  void close(const Eigen::MatrixX3d& values, Positions& x) const;
  /// What holds the averages, if `forces` are all others.
  [[nodiscard]] Eigen::MatrixX3d forces_of_averages(const Positions& forces) const;
  /// An x that meets the averages, from itself as b; what it does is taken out of b and of the gaps of stiff rows.
  Eigen::MatrixX3d start_held(const Positions& gaps, Positions& x, Positions& b, Positions& stiff_gaps) const;
  /// Brings averages and stiff rows that are held exactly there.
  void close_exact(const Positions& gaps, Positions& x) const;
  void correct_with_stiff(const Positions& gaps, Positions& multipliers, Positions& correction) const;
  /// Replaces b by x, as exact as rounding allows; sets the forces of stiff rows, (n_stiff, 3).
  void solve_exactly(double accuracy, const Positions& gaps, Positions& of_stiff, Positions& b) const;
  /// The same for stiff rows while the averages are 0.
  void solve_stiff_exactly(double accuracy, const Positions& stiff_gaps, Positions& of_stiff, Positions& b) const;
  void erase_fixed(Positions& x) const;
  /// A x, with the grounding of what is not released, 0 at fixed unknowns.
  void multiply_held(const Positions& x, Positions& result) const;

  const SparseMatrix* matrix_;  ///< A
  SparseMatrix own_matrix_;     ///< if that is not K
  Workers workers_;
  std::vector<char> is_fixed_;
  std::vector<int> fixed_;  ///< where is_fixed_ is not 0
  std::vector<LinearRow> averages_;
  std::vector<int> grounded_;
  int n_released_ = 0;                     ///< of them, the first, which are released
  std::vector<double> grounding_;          ///< added to the diagonal of A in the factor, of each grounded unknown
  std::unique_ptr<Factorization> factor_;  ///< of A with grounding and the penalties of stiff rows
  std::unique_ptr<StiffRows> stiff_;       ///< over factor_; null without stiff rows
  int n_exact_ = 0;                        ///< of these, the last, which are held exactly
  SmallestChange to_exact_;                ///< of averages and these; none without these
  SparseMatrix free_averages_;             ///< W: (n, n_averages), of free unknowns
  SparseMatrix moves_;                     ///< Z: (n, n_released), each component as one, 1 / its grounding
  SparseMatrix move_forces_;               ///< V: (n, n_released), what soft and stiff rows do against that
  std::unique_ptr<Border> border_;         ///< of factor_, with W and V; null if there are none
  LeastSquares dense_;                     ///< for their multipliers and how far components move
  LeastSquares overlaps_;                  ///< W^T W
};

}  // namespace arap
