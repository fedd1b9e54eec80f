// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/tet_arap.h"

#include "base/available_memory.h"
#include "base/option_bounds.h"
#include "models/input_checks.h"
#include "models/model_space.h"
#include "models/tet_arap/tet_model.h"
#include "models/vertex_model.h"

namespace arap {

namespace {

/// A little more than what a bind takes at its peak, beside the mesh. Measured on cubes of six tetrahedra.
double bytes_to_bind(const TetMesh& mesh) {
  constexpr double kPerVertex = 600;
  constexpr double kPerTet = 400;
  return kPerVertex * mesh.n_vertices() + kPerTet * mesh.n_tets();
}

}  // namespace

void TetOptions::validate() const { require_threads(threads); }

struct TetArap::Impl {
  Impl(const TetMesh& mesh, const TetOptions& options, const VertexProperties& properties, const Progress& progress)
      : space(mesh), posed(space, prepare(mesh, options, properties, progress), 3) {}

  const PreparedModel& prepare(const TetMesh& mesh, const TetOptions& options, const VertexProperties& properties,
                               const Progress& progress) {
    model.rest = space.to_model(mesh.positions(), Workers(1));
    space.renumber(prepare_tets(model, mesh, options, properties, progress));
    return model;
  }

  ModelSpace space;
  PreparedModel model;
  VertexModel posed;
};

TetArap::TetArap(const TetMesh& mesh, const TetOptions& options, const VertexProperties& properties,
                 const Progress& progress) {
  options.validate();
  properties.validate(mesh.n_vertices());
  require_memory(bytes_to_bind(mesh), "this mesh");
  impl_ = std::make_unique<Impl>(mesh, options, properties, progress);
  if (impl_->model.is_large()) return_freed_memory();
}

TetArap::~TetArap() = default;
TetArap::TetArap(TetArap&&) noexcept = default;
TetArap& TetArap::operator=(TetArap&&) noexcept = default;

void TetArap::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  impl_->posed.take(impl_->posed.prepare(constraints, progress));
}

SolveResult TetArap::solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                           const Progress& progress, std::span<float> out) {
  return impl_->posed.solve(targets, options, rotations, progress, out);
}

void TetArap::reset() { impl_->posed.take(impl_->posed.at_rest()); }

void TetArap::set_positions(const Positions& positions) { impl_->posed.take(impl_->posed.fitted(positions)); }

Positions TetArap::positions() const { return impl_->posed.positions(); }

double TetArap::energy(const Positions& positions) { return impl_->posed.energy(positions); }

Positions TetArap::energy_gradient(const Positions& positions) { return impl_->posed.energy_gradient(positions); }

int TetArap::n_vertices() const { return impl_->space.n_input_vertices(); }
int TetArap::n_parts() const { return impl_->model.n_parts; }
const std::vector<int>& TetArap::part_of_vertex() const { return impl_->posed.part_of_vertex(); }
const std::vector<int>& TetArap::loose_vertices() const { return impl_->posed.loose_vertices(); }
int TetArap::n_parts_at_rest() const { return impl_->posed.n_parts_at_rest(); }
int TetArap::n_factorizations() const { return impl_->posed.n_factorizations(); }
int TetArap::threads() const { return impl_->model.workers.threads(); }

}  // namespace arap
