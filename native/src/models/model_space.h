// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "arap/tet_mesh.h"
#include "arap/types.h"
#include "parallel/workers.h"

namespace arap {

/// Between the user's mesh and the model's: the model is centred at the box of its parts, has diagonal 1 there, has one
/// vertex where open seams are joined, and numbers its vertices as its linear solver wants them. A loose vertex rests
/// at its center: nothing hangs on it, and far away it would take the digits of single precision from all others.
class ModelSpace {
 public:
  /// @param mesh  the user's, at rest
  explicit ModelSpace(const PolygonMesh& mesh) : ModelSpace(mesh.positions(), mesh.part_of_vertex()) {}
  explicit ModelSpace(const TetMesh& mesh) : ModelSpace(mesh.positions(), mesh.part_of_vertex()) {}

  /// Makes vertices one: same_as[v] is the first vertex at the place of v.
  void join(const std::vector<int>& same_as);
  /// Numbers the model's vertices anew: new_of_old[m] takes the place of m.
  void renumber(const std::vector<int>& new_of_old);

  [[nodiscard]] int n_input_vertices() const { return static_cast<int>(model_vertex_.size()); }
  [[nodiscard]] int n_model_vertices() const { return static_cast<int>(input_vertex_.size()); }
  /// Of each vertex of the user's.
  [[nodiscard]] const std::vector<int>& model_vertices() const { return model_vertex_; }
  /// The first vertex of the user's at each of the model's.
  [[nodiscard]] const std::vector<int>& input_vertices() const { return input_vertex_; }

  /// Points of the user's space, row by row.
  [[nodiscard]] Positions points_to_model(const Positions& points) const {
    return (points.rowwise() - center_) / size_;
  }
  [[nodiscard]] Positions points_to_input(const Positions& points) const {
    return (points * size_).rowwise() + center_;
  }
  /// The targets of a set.
  [[nodiscard]] Positions targets_to_model(const Positions& targets, const ConstraintSet& of_input) const;

  [[nodiscard]] Positions to_model(const Positions& of_input, const Workers& workers) const;
  [[nodiscard]] Positions to_input(const Positions& of_model, const Workers& workers) const;
  /// The same into memory that may be there already.
  void to_input(const Positions& of_model, const Workers& workers, Positions& result) const;
  /// The same in single precision, row by row; false where a number is not finite, or too large for it.
  [[nodiscard]] bool write_to_input(const Positions& of_model, const Workers& workers, std::span<float> of_input) const;
  [[nodiscard]] std::vector<double> to_model(const std::vector<double>& of_input) const;
  /// A vertex belongs to the region of any of its copies; of several, to the lowest.
  [[nodiscard]] std::vector<int> regions_to_model(const std::vector<int>& of_input) const;
  /// The mesh given to the constructor.
  [[nodiscard]] PolygonMesh make_model(const PolygonMesh& mesh) const;
  /// Another mesh beside it, whose vertices keep their numbers.
  [[nodiscard]] PolygonMesh beside_model(const PolygonMesh& mesh) const;
  [[nodiscard]] Segment to_model(const Segment& of_input) const;
  [[nodiscard]] ConstraintSet to_model(ConstraintSet of_input) const;

  [[nodiscard]] Eigen::RowVector3d to_input(const Eigen::RowVector3d& point) const { return point * size_ + center_; }

  [[nodiscard]] double size() const { return size_; }
  /// @param dimension  of what has the energy: 2, a surface; 3, a solid
  [[nodiscard]] double energy_to_input(double energy, int dimension) const;
  /// Gradient of energy_to_input() of to_model() of positions: 0 at the vertices that this does not read.
  [[nodiscard]] Positions gradient_to_input(const Positions& of_model, int dimension) const;

 private:
  /// A loose vertex of the user's, and where it is at rest from the center.
  struct Loose {
    int vertex;
    Eigen::RowVector3d shift;
  };

  ModelSpace(const Positions& rest, const std::vector<int>& part_of_vertex);

  Eigen::RowVector3d center_;
  double size_ = 1;
  std::vector<int> model_vertex_;  ///< of each input vertex
  std::vector<int> input_vertex_;  ///< the first one of each model vertex
  std::vector<Loose> loose_;       ///< by vertex
};

}  // namespace arap
