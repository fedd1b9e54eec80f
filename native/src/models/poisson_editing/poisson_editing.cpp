// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/poisson_editing.h"

#include <optional>
#include <utility>

#include "base/available_memory.h"
#include "base/option_bounds.h"
#include "models/input_checks.h"
#include "models/model_space.h"
#include "models/poisson_editing/poisson_solver.h"
#include "models/user_vertices.h"

namespace arap {

namespace {

/// A little more than what a bind takes at its peak, beside the mesh.
double bytes_to_bind(const PolygonMesh& mesh) {
  constexpr double kPerVertex = 900;
  constexpr double kPerFurtherCorner = 300;  // of a face: it is joined with all others
  return kPerVertex * mesh.n_vertices() + kPerFurtherCorner * (mesh.n_corners() - 3.0 * mesh.n_faces());
}

void require_orientation(std::span<const Matrix3> rotations) {
  for (size_t k = 0; k < rotations.size(); ++k)
    if (const double determinant = rotations[k].determinant(); !(determinant > 0))
      throw InvalidInput(
          text("rotations[", k, "] has determinant ", determinant, ", must be above 0: a rotation times a scale"));
}

}  // namespace

void PoissonOptions::validate() const { require_threads(threads); }

struct PoissonEditing::Impl {
  Impl(const PolygonMesh& mesh, const PoissonOptions& options, const Progress& progress)
      : space(mesh),
        user(space, prepare(mesh, options, progress).part_of_vertex, model.prepared.workers),
        solver(model, options.propagation) {
    rest();
  }

  const PreparedModel& prepare(const PolygonMesh& mesh, const PoissonOptions& options, const Progress& progress) {
    space.renumber(prepare_poisson(model, space.make_model(mesh), options, progress));
    return model.prepared;
  }

  void rest() { pose = {model.prepared.rest, Positions(0, 3)}; }

  /// False if it was cancelled.
  bool solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
             const Progress& progress, std::span<float> out, SolveResult& result) {
    const bool goes_on = options.initial_guess == InitialGuess::kPrevious;
    std::optional<PoissonSolver::Pose> next = solver.solve(space.targets_to_model(targets, constraints), rotations,
                                                           goes_on ? pose.turns : Positions(0, 3), progress);
    if (!user.hand_over(next ? next->positions : pose.positions, out, result))
      throw SolverError("the positions are no longer finite; the last good pose is kept");
    if (next) pose = std::move(*next);
    return next.has_value();
  }

  ModelSpace space;
  PoissonModel model;
  UserVertices user;
  PoissonSolver solver;
  ConstraintSet constraints;
  PoissonSolver::Pose pose;
  int n_factorizations = 0;
};

PoissonEditing::PoissonEditing(const PolygonMesh& mesh, const PoissonOptions& options, const Progress& progress) {
  options.validate();
  require_memory(bytes_to_bind(mesh), "this mesh");
  impl_ = std::make_unique<Impl>(mesh, options, progress);
}

PoissonEditing::~PoissonEditing() = default;
PoissonEditing::PoissonEditing(PoissonEditing&&) noexcept = default;
PoissonEditing& PoissonEditing::operator=(PoissonEditing&&) noexcept = default;

void PoissonEditing::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  impl_->user.require_constraints(constraints);
  if (impl_->solver.has_constraints() && constraints == impl_->constraints) return;
  ConstraintSet copy = constraints;
  impl_->solver.set_constraints(impl_->space.to_model(constraints), progress);
  impl_->constraints = std::move(copy);
  ++impl_->n_factorizations;
}

SolveResult PoissonEditing::solve(const Positions& targets, const SolveOptions& options,
                                  std::span<const Matrix3> rotations, const Progress& progress, std::span<float> out) {
  options.validate();
  require_constrained(impl_->solver.has_constraints());
  require_targets(impl_->constraints, targets, rotations);
  require_orientation(rotations);
  require_out(out, n_vertices());
  SolveResult result;
  result.parts_at_rest = impl_->solver.parts_at_rest();
  result.loose_vertices = loose_vertices();
  impl_->user.guarded(out, impl_->pose.positions, [&] {
    const bool is_done = impl_->solve(targets, options, rotations, progress, out, result);
    result.stop_reason = is_done ? StopReason::kConverged : StopReason::kCancelled;
    result.iterations = is_done ? 1 : 0;
  });
  return result;
}

void PoissonEditing::reset() { impl_->rest(); }

void PoissonEditing::set_positions(const Positions& positions) {
  impl_->pose.positions = impl_->user.checked_to_model(positions);
}

Positions PoissonEditing::positions() const {
  return impl_->space.to_input(impl_->pose.positions, impl_->model.prepared.workers);
}

int PoissonEditing::n_vertices() const { return impl_->user.size(); }
int PoissonEditing::n_parts() const { return impl_->model.prepared.n_parts; }
const std::vector<int>& PoissonEditing::part_of_vertex() const { return impl_->user.part_of_vertex(); }
const std::vector<int>& PoissonEditing::loose_vertices() const { return impl_->user.loose_vertices(); }
int PoissonEditing::n_parts_at_rest() const {
  return impl_->solver.has_constraints() ? static_cast<int>(impl_->solver.parts_at_rest().size()) : 0;
}
int PoissonEditing::n_factorizations() const { return impl_->n_factorizations; }
int PoissonEditing::threads() const { return impl_->model.prepared.workers.threads(); }

}  // namespace arap
