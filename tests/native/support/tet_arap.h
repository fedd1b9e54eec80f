// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "optimize/engine.h"
#include "support/meshes.h"

namespace arap_test {

struct TetMesh {
  Positions positions;                   ///< (n, 3), of size 1
  std::vector<std::array<int, 4>> tets;  ///< of positive volume

  /// Cubes of the same size, nx ny nz of them, six tetrahedra each.
  static TetMesh blocks(int nx, int ny, int nz);

  /// Gradients of a tetrahedron's linear basis functions, row by row.
  [[nodiscard]] Eigen::Matrix<double, 4, 3> gradients(int tet) const;
  [[nodiscard]] double volume(int tet) const;
  /// A point as a row over the vertices of a tetrahedron, by barycentric coordinates.
  [[nodiscard]] arap::LinearRow point_in(int tet, const Eigen::Vector4d& coordinates) const;
};

/// ARAP on tetrahedra, E = sum_t V_t |F_t - R_t|^2: how small a model over the engine is. An assembler,
arap::PreparedModel& assemble(arap::PreparedModel& model, const TetMesh& mesh, int threads = 1,
                              const std::vector<int>& region_of_vertex = {},
                              arap::LinearSolverKind solver = arap::LinearSolverKind::kBlockLdlt);

/// and a face. The vertices are the unknowns.
class TetArap {
 public:
  explicit TetArap(const TetMesh& mesh, int threads = 1, const std::vector<int>& region_of_vertex = {},
                   arap::LinearSolverKind solver = arap::LinearSolverKind::kBlockLdlt)
      : engine_(assemble(model_, mesh, threads, region_of_vertex, solver)) {}

  void set_constraints(const arap::ModelConstraints& constraints) { engine_.set_constraints(constraints, {}); }
  arap::IterationReport solve(const Positions& targets, const arap::SolveOptions& options) {
    return engine_.solve(targets, options, {}, {}, [](const Positions& p) { return p.allFinite(); });
  }
  [[nodiscard]] const Positions& positions() const { return engine_.positions(); }
  [[nodiscard]] arap::Engine& engine() { return engine_; }

 private:
  arap::PreparedModel model_;
  arap::Engine engine_;
};

}  // namespace arap_test
