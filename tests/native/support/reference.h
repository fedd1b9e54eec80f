// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/constraints.h"
#include "arap/options.h"
#include "support/meshes.h"

namespace arap_test {

/// Surface ARAP as plainly as the papers' formulas can be written down: sums over cells in double, dense matrices,
/// Jacobi SVD. It shares nothing with the library but its array types, takes O(n^3), and is what the library is checked
/// against.
class Reference {
 public:
  /// One edge of one cell: weight |(p'_a - p'_b) - R_cell (p_a - p_b)|^2.
  struct Term {
    int cell, a, b;
    double weight;
  };

  Reference(const MeshData& mesh, arap::Energy energy, arap::EdgeWeights weights, std::vector<double> stiffness = {});

  /// One rotation a node: E = sum_c sum_j w_jc cell_j(R_c).
  /// @param weights  (n, n_nodes), rows sum to 1
  void share_rotations(const Eigen::MatrixXd& weights);

  /// The double sum of the energy, with given rotations.
  [[nodiscard]] double energy(const Positions& positions, const std::vector<Matrix3>& rotations) const;
  /// The same with the best rotation for every cell.
  [[nodiscard]] double energy(const Positions& positions) const;
  /// omega_i |p'_i - t_i|^2 of the soft constraints.
  [[nodiscard]] double soft_energy(const arap::ConstraintSet& constraints, const Positions& targets,
                                   const Positions& positions) const;
  /// Of every cell, from the SVD of its covariance.
  [[nodiscard]] std::vector<Matrix3> rotations(const Positions& positions) const;
  /// (n, 3): derivative of energy() with the rotations held.
  [[nodiscard]] Positions gradient(const Positions& positions, const std::vector<Matrix3>& rotations) const;
  /// The same with the best rotation for every cell.
  [[nodiscard]] Positions gradient(const Positions& positions) const;
  /// Half the Hessian's 3x3 block-scalars: E is 1/2 <p', K p'> plus terms of lower order. (n, n).
  [[nodiscard]] Eigen::MatrixXd matrix() const;
  /// (n, 3): K p' equals this where the gradient vanishes.
  [[nodiscard]] Positions right_hand_side(const std::vector<Matrix3>& rotations) const;

  /// Rest positions, hard vertices at their targets.
  [[nodiscard]] Positions rest_guess(const arap::ConstraintSet& constraints, const Positions& targets) const;
  /// min |K p' - K p|^2 under the hard constraints.
  [[nodiscard]] Positions laplacian_guess(const arap::ConstraintSet& constraints, const Positions& targets) const;

  struct Solution {
    Positions positions;
    int iterations = 0;
    double step = 0;               ///< largest movement in the last iteration / diagonal
    std::vector<double> energies;  ///< at the start and after each iteration, with the soft constraints' terms
  };
  /// Local/global from `start`, until the step is at most `step_tolerance`. Every part needs a hard vertex, a soft one
  /// or a patch.
  [[nodiscard]] Solution solve(const arap::ConstraintSet& constraints, const Positions& targets, const Positions& start,
                               int max_iterations, double step_tolerance = 0) const;

 private:
  void assemble_spokes(const std::vector<double>& stiffness);
  void assemble_spokes_and_rims(const std::vector<double>& stiffness);
  void add_term(int cell, int a, int b, double weight);

  struct Triangle {
    std::array<int, 3> vertices;
    std::array<double, 3> cotangents;  ///< at each corner
    double weight;
  };
  void cut_into_triangles(const MeshData& mesh, arap::EdgeWeights weights);

  int n_;
  int n_cells_;
  double diagonal_;
  Positions rest_;
  std::vector<Triangle> triangles_;
  std::vector<Term> terms_;
};

}  // namespace arap_test
