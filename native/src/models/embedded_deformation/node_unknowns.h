// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "arap/embedded_deformation.h"
#include "arap/types.h"
#include "sparse/sparse.h"

namespace arap {

/// What a Newton step solves for: the changes of the nodes' states, numbered node by node. Of all terms of the
/// energy but E_rot the matrix is known for the rows of a state (deformation_graph.h): K, (4 m, 4 m), the same for x, y
/// and z. An energy here is the sum of squares without a factor, a gradient half of it, a matrix the product J^T J
/// and curvature.
class NodeUnknowns {
 public:
  /// What a matrix has of the second derivatives of the errors, which J^T J leaves out.
  enum class Curvature {
    kWhole,        ///< then steps near the minimum are Newton's; but the matrix need not be positive definite
    kNotNegative,  ///< of each node what is not negative: without it steps swing about where nodes are stretched
  };

  NodeUnknowns() = default;
  NodeUnknowns(const NodeUnknowns&) = delete;
  NodeUnknowns& operator=(const NodeUnknowns&) = delete;
  virtual ~NodeUnknowns() = default;

  [[nodiscard]] virtual int per_node() const = 0;
  /// What the nodes' own term costs.
  [[nodiscard]] virtual double energy(const Positions& state) const = 0;
  /// The matrix at a state. Its pattern is always the same. @param of_state  as gradient()
  virtual const SparseMatrix& matrix(const Positions& state, const Positions& of_state, Curvature curvature) = 0;
  /// Half the gradient by the unknowns, of which `of_state`, (4 m, 3), is the part without the nodes' own term.
  [[nodiscard]] virtual Eigen::VectorXd gradient(const Positions& state, const Positions& of_state) const = 0;
  /// The state after a step.
  [[nodiscard]] virtual Positions stepped(const Positions& state, const Eigen::VectorXd& step) const = 0;

  /// @param rotation_weight  of E_rot, which only affine nodes have
  /// @param K                (4 m, 4 m), symmetric
  static std::unique_ptr<NodeUnknowns> make(GraphNodes kind, double rotation_weight, const SparseMatrix& K);
};

}  // namespace arap
