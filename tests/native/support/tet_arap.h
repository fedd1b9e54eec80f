// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "arap/tet_mesh.h"
#include "optimize/engine.h"
#include "support/meshes.h"

namespace arap_test {

using arap::TetMesh;

/// Cubes of the same size, nx ny nz of them, six tetrahedra each; of size 1.
TetMesh tet_blocks(int nx, int ny, int nz);
/// The same tetrahedra at other places.
TetMesh transformed(const TetMesh& mesh, const std::function<Vector3(const Vector3&)>& map);

/// Gradients of a tetrahedron's linear basis functions, row by row.
Eigen::Matrix<double, 4, 3> gradients(const TetMesh& mesh, int tet);
double tet_volume(const TetMesh& mesh, int tet);
/// A point as a row over the vertices of a tetrahedron, by barycentric coordinates.
arap::LinearRow point_in(const TetMesh& mesh, int tet, const Eigen::Vector4d& coordinates);

/// The model of a mesh that is of size 1 already, its vertices numbered as they are.
arap::PreparedModel& assemble(arap::PreparedModel& model, const TetMesh& mesh, int threads = 1,
                              const std::vector<int>& region_of_vertex = {},
                              const arap::SolverFactory* solver_factory = nullptr);

/// The engine over tetrahedra, for what no face hands to it: rows. How little a model needs.
class TetEngine {
 public:
  explicit TetEngine(const TetMesh& mesh, int threads = 1, const std::vector<int>& region_of_vertex = {},
                     const arap::SolverFactory* solver_factory = nullptr)
      : engine_(assemble(model_, mesh, threads, region_of_vertex, solver_factory)) {}

  void set_constraints(const arap::ModelConstraints& constraints) { engine_.take(engine_.prepare(constraints, {})); }
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
