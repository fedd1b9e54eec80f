// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/result.h"
#include "arap/types.h"
#include "models/model_space.h"
#include "parallel/workers.h"

namespace arap {

/// The user's side of a model that has the user's vertices: checks what calls are given, and takes it to the model and
/// back. All checks throw InvalidInput.
class UserVertices {
 public:
  /// @param space           numbered as the model is; it and the workers must outlive this
  /// @param part_of_vertex  of each of the model's, -1 = loose
  UserVertices(const ModelSpace& space, const std::vector<int>& part_of_vertex, const Workers& workers);

  [[nodiscard]] const ModelSpace& space() const { return space_; }
  [[nodiscard]] int size() const { return space_.n_input_vertices(); }
  /// Of each vertex, -1 = loose.
  [[nodiscard]] const std::vector<int>& part_of_vertex() const { return part_of_vertex_; }
  [[nodiscard]] const std::vector<int>& loose_vertices() const { return loose_vertices_; }

  void require_constraints(const ConstraintSet& constraints) const;

  /// (n, 3) in the model, of positions of the user's.
  [[nodiscard]] Positions checked_to_model(const Positions& positions) const;

  /// Writes positions of the model into `out`, or into the result's own where that is empty; false if one of them is
  /// not finite.
  [[nodiscard]] bool hand_over(const Positions& of_model, std::span<float> out, SolveResult& result) const;

  /// Calls act(). If it throws, `out` has the positions that the model has `now`.
  template <class Act>
  void guarded(std::span<float> out, const Positions& now, const Act& act) const {
    try {
      act();
    } catch (...) {
      if (!out.empty()) static_cast<void>(space_.write_to_input(now, workers_, out));
      throw;
    }
  }

 private:
  const ModelSpace& space_;
  const Workers& workers_;
  std::vector<int> part_of_vertex_;
  std::vector<int> loose_vertices_;
};

}  // namespace arap
