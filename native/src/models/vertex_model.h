// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "arap/constraints.h"
#include "arap/result.h"
#include "arap/types.h"
#include "models/model_space.h"
#include "models/user_vertices.h"
#include "optimize/engine.h"

namespace arap {

/// The face of a model whose unknowns are the user's vertices: all acts after the bind, in the user's space.
/// SurfaceArap and TetArap say what each does.
class VertexModel {
 public:
  /// @param space      numbered as the model is; it and the model must outlive this
  /// @param model      whole
  /// @param dimension  of what has the energy: 2, a surface; 3, a solid
  VertexModel(const ModelSpace& space, const PreparedModel& model, int dimension);

  /// Constraints, to take() once nothing can fail any more.
  struct Change {
    ConstraintSet constraints;
    Engine::Change of_engine;  ///< empty if these are the constraints already
  };
  [[nodiscard]] Change prepare(const ConstraintSet& constraints, const Progress& progress);
  void take(Change change) noexcept;
  SolveResult solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                    const Progress& progress, std::span<float> out);
  [[nodiscard]] Pose at_rest() const { return engine_.at_rest(); }
  [[nodiscard]] Pose fitted(const Positions& positions) { return engine_.fitted(user_.checked_to_model(positions)); }
  void take(Pose pose) noexcept { engine_.take(std::move(pose)); }
  /// As Engine::undo().
  void undo() noexcept { engine_.undo(); }
  [[nodiscard]] Positions positions() const;
  [[nodiscard]] double energy(const Positions& positions);
  [[nodiscard]] Positions energy_gradient(const Positions& positions);

  /// Of each vertex of the user's, -1 = loose.
  [[nodiscard]] const std::vector<int>& part_of_vertex() const { return user_.part_of_vertex(); }
  [[nodiscard]] const std::vector<int>& loose_vertices() const { return user_.loose_vertices(); }
  [[nodiscard]] int n_parts_at_rest() const {
    return engine_.has_constraints() ? static_cast<int>(engine_.parts_at_rest().size()) : 0;
  }
  [[nodiscard]] int n_factorizations() const { return engine_.n_factorizations(); }

 private:
  /// Energy of the input and gradient of the model.
  double evaluate(const Positions& positions, Positions& gradient);

  const ModelSpace& space_;
  const Workers& workers_;
  int dimension_;
  UserVertices user_;
  ConstraintSet constraints_;
  Engine engine_;
};

}  // namespace arap
