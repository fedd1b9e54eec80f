// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/constraints.h"
#include "arap/options.h"
#include "support/meshes.h"

namespace arap_test {

/// The papers' formulas of surface ARAP as plainly as possible: sums over cells in double, dense matrices, Jacobi SVD.
/// O(n^3). The library is tested against it; it shares only array types with the library.
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

  /// The energy for given rotations.
  [[nodiscard]] double energy(const Positions& positions, const std::vector<Matrix3>& rotations) const;
  /// The energy for the best rotation of every cell.
  [[nodiscard]] double energy(const Positions& positions) const;
  /// Sum of omega_i |p'_i - t_i|^2 of the soft constraints.
  [[nodiscard]] double soft_energy(const arap::ConstraintSet& constraints, const Positions& targets,
                                   const Positions& positions) const;
  /// The best rotation of every cell, from the SVD of its covariance.
  [[nodiscard]] std::vector<Matrix3> rotations(const Positions& positions) const;
  /// (n, 3) derivative of energy() for fixed rotations.
  [[nodiscard]] Positions gradient(const Positions& positions, const std::vector<Matrix3>& rotations) const;
  /// The same with the best rotation for every cell.
  [[nodiscard]] Positions gradient(const Positions& positions) const;
  /// (n, n) K: E is 1/2 <p', K p'> plus terms of lower order.
  [[nodiscard]] Eigen::MatrixXd matrix() const;
  /// (n, 3) b: the gradient vanishes if K p' = b.
  [[nodiscard]] Positions right_hand_side(const std::vector<Matrix3>& rotations) const;

  /// Rest positions, hard vertices at their targets.
  [[nodiscard]] Positions rest_guess(const arap::ConstraintSet& constraints, const Positions& targets) const;
  /// min |K p' - K p|^2 under the hard constraints.
  [[nodiscard]] Positions laplacian_guess(const arap::ConstraintSet& constraints, const Positions& targets) const;

  struct Solution {
    Positions positions;
    int iterations = 0;
    double step = 0;               ///< largest movement in the last iteration, relative to the diagonal
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
