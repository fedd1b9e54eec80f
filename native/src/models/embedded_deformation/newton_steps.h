// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "arap/embedded_deformation.h"
#include "arap/options.h"
#include "arap/types.h"
#include "cholesky/linear_solver.h"
#include "constraints/linear_rows.h"
#include "models/embedded_deformation/deformation_graph.h"
#include "models/embedded_deformation/node_unknowns.h"
#include "parallel/meter.h"
#include "parallel/workers.h"

namespace arap {

/// A constraint on the nodes: a row of their state, and its weight in E_con before all are scaled, or kHard.
struct GraphConstraints {
  std::vector<DeformationGraph::Combination> combinations;
  std::vector<double> weights;
};

/// Minimizes the energy of a graph under a set of constraints. A step is Newton's where the matrix with all second
/// derivatives is positive definite, else of Gauss and Newton, with as much of them as is not negative.
class NewtonSteps {
 public:
  /// Throws SolverError, Cancelled.
  /// @param is_held  (m,) whether anything constrains the part of a node; the others stay at rest
  NewtonSteps(const DeformationGraph& graph, const EmbeddedOptions& options, const GraphConstraints& constraints,
              const std::vector<char>& is_held, const Workers& workers, const MeterPart& meter);

  struct Report {
    double energy_before = 0;  ///< without hard constraints
    double energy_after = 0;
    int iterations = 0;
    double step = 0;  ///< of the last iteration: the largest movement of a node or of its neighbourhood
    StopReason stop_reason = StopReason::kMaxIterations;
  };
  /// Moves `state` towards the targets, (n_constraints, 3): first as one body, if that alone is far better. Throws
  /// SolverError; the state is then any.
  Report solve(const Positions& targets, const SolveOptions& options, const Progress& progress, Positions& state);

  /// Where a solve may start: all nodes of a state moved as one body, as the targets fit best.
  [[nodiscard]] Positions turned(const Positions& targets, const Positions& state) const;

  /// Forgets all that the last solve has left: the next one is as the first.
  void forget() noexcept;

  [[nodiscard]] int n_factorizations() const { return n_factorizations_; }

 private:
  /// A state, and what its rows leave of the goals, (n_rows, 3).
  struct Place {
    Positions state;
    Positions gaps;
  };
  struct Step {
    double moved = 0;
    double whole = 0;      ///< before it was cut: an estimate of how far the minimum is
    bool is_lost = false;  ///< in rounding: nothing moved, as no part of it lowers the energy that double can tell
  };

  /// (n_rows, 3): what edges want, then the targets without what does not move with the nodes.
  [[nodiscard]] Positions wanted(const Positions& targets) const;
  [[nodiscard]] Place place(const Positions& goals, Positions state) const;
  /// The same as above. @param goals  wanted()
  [[nodiscard]] Positions turned(const Positions& goals, const Place& at) const;
  /// Gaps as hard constraints have learned to see them.
  [[nodiscard]] Positions seen(const Place& at) const;
  /// The energy with hard rows, counted with their weight. @param gaps  seen()
  [[nodiscard]] double cost(const Positions& state, const Positions& gaps) const;
  [[nodiscard]] double energy(const Place& at) const;
  /// One step to less cost. Throws SolverError.
  Step step(const Positions& goals, Place& at);
  void factorize(const Positions& state, const Positions& of_state);
  /// The whole step.
  [[nodiscard]] Eigen::VectorXd solve_for(const Eigen::VectorXd& gradient) const;
  [[nodiscard]] double largest_gap(const Place& at) const;
  void forget_multipliers() noexcept;
  /// Moves the targets of hard constraints by the gaps that are left, or finds that the nodes can do no more.
  void learn(const Place& at, double gap);
  [[nodiscard]] double movement(const Positions& from, const Positions& to) const;

  const Workers& workers_;
  double node_distance_;
  Positions nodes_;  ///< (m, 3) at rest
  Eigen::Index n_edge_rows_ = 0;
  Positions edge_goals_;
  Positions constants_;        ///< (n_constraints, 3) of the combinations
  std::vector<char> is_hard_;  ///< (n_constraints,)
  RowMatrix rows_;             ///< edges, then constraints
  Eigen::VectorXd weights_;    ///< of the rows
  std::unique_ptr<NodeUnknowns> unknowns_;
  std::vector<char> is_erased_;
  std::unique_ptr<LinearSolver> solver_;
  /// At a former state, as long as steps get small quickly: in a drag it costs far more than the rest of a step.
  std::unique_ptr<Factorization> factor_;
  bool is_stale_ = true;    ///< the next step is to make another one
  Positions last_targets_;  ///< of which learned_ is
  /// Multipliers of hard constraints.
  struct Learned {
    Positions moves;                                       ///< (n_constraints, 3) of the targets
    double gap = std::numeric_limits<double>::infinity();  ///< when it was learned last
    int times = 0;
    bool is_all = false;  ///< that the nodes can do
  };
  Learned learned_;
  int n_factorizations_ = 0;
};

}  // namespace arap
