// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/surface_arap.h"

#include <algorithm>

#include "base/available_memory.h"
#include "models/surface_arap/posed_surface.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

/// Radius of a patch, in rigidity radii.
constexpr double kPatchRadius = 1.5;

/// A little more than what a bind takes at its peak, beside the mesh. Measured on regular meshes of triangles and
/// quads, and on one with 200 faces a vertex.
double bytes_to_bind(const PolygonMesh& mesh, Energy energy) {
  const double per_vertex = energy == Energy::kRotationNodes ? 1570 : 900;  // a vertex is in more cells of nodes
  constexpr double kPerLooseVertex = 600;
  constexpr double kPerFurtherCorner = 300;  // of a face: it is joined with all others
  constexpr double kPerFace = 400;           // if a vertex is in many
  const auto n_loose = static_cast<double>(mesh.loose_vertices().size());
  const double n_further_corners = mesh.n_corners() - 3.0 * mesh.n_faces();
  return std::max(per_vertex * (mesh.n_vertices() - n_loose), kPerFace * mesh.n_faces()) + kPerLooseVertex * n_loose +
         kPerFurtherCorner * n_further_corners;
}

}  // namespace

struct SurfaceArap::Impl {
  Impl(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties, const Progress& progress)
      : patch_radius(kPatchRadius * options.rigidity_radius), surface(mesh, options, properties, progress) {}

  double patch_radius;  ///< of patches without one
  PosedSurface surface;
  VertexModel& posed = surface.posed;
  std::unique_ptr<EdgeGraph> graph;  ///< of the model; made when first needed
};

SurfaceArap::SurfaceArap(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties,
                         const Progress& progress) {
  options.validate();
  properties.validate(mesh.n_vertices());
  require_memory(bytes_to_bind(mesh, options.energy), "this mesh");
  impl_ = std::make_unique<Impl>(mesh, options, properties, progress);
  if (impl_->surface.model.prepared.is_large()) return_freed_memory();
}

SurfaceArap::~SurfaceArap() = default;
SurfaceArap::SurfaceArap(SurfaceArap&&) noexcept = default;
SurfaceArap& SurfaceArap::operator=(SurfaceArap&&) noexcept = default;

void SurfaceArap::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  impl_->posed.take(impl_->posed.prepare(constraints, progress));
}

SolveResult SurfaceArap::solve(const Positions& targets, const SolveOptions& options,
                               std::span<const Matrix3> rotations, const Progress& progress, std::span<float> out) {
  return impl_->posed.solve(targets, options, rotations, progress, out);
}

Patch SurfaceArap::patch_around(const std::vector<int>& vertices, double radius) {
  require_patch_sources(vertices, radius, impl_->posed.part_of_vertex());
  const SurfaceModel& model = impl_->surface.model;
  const ModelSpace& space = impl_->surface.space;
  if (impl_->graph == nullptr)
    impl_->graph = std::make_unique<EdgeGraph>(model.prepared.energy.K, model.prepared.rest, threads());
  std::vector<int> sources;
  sources.reserve(vertices.size());
  for (const int v : vertices) sources.push_back(space.model_vertices()[v]);
  Patch patch =
      find_patch(*impl_->graph, model.areas, model.prepared.rest, sources, radius > 0 ? radius : impl_->patch_radius);
  for (int& v : patch.vertices) v = space.input_vertices()[v];
  patch.rest_position = space.to_input(Eigen::RowVector3d(patch.rest_position)).transpose();
  return patch;
}

void SurfaceArap::reset() { impl_->posed.take(impl_->posed.at_rest()); }

void SurfaceArap::set_positions(const Positions& positions) { impl_->posed.take(impl_->posed.fitted(positions)); }

Positions SurfaceArap::positions() const { return impl_->posed.positions(); }

double SurfaceArap::energy(const Positions& positions) { return impl_->posed.energy(positions); }

Positions SurfaceArap::energy_gradient(const Positions& positions) { return impl_->posed.energy_gradient(positions); }

int SurfaceArap::n_vertices() const { return impl_->surface.space.n_input_vertices(); }
int SurfaceArap::n_parts() const { return impl_->surface.model.prepared.n_parts; }
const std::vector<int>& SurfaceArap::part_of_vertex() const { return impl_->posed.part_of_vertex(); }
const std::vector<int>& SurfaceArap::loose_vertices() const { return impl_->posed.loose_vertices(); }
int SurfaceArap::n_parts_at_rest() const { return impl_->posed.n_parts_at_rest(); }
int SurfaceArap::n_factorizations() const { return impl_->posed.n_factorizations(); }
int SurfaceArap::threads() const { return impl_->surface.model.prepared.workers.threads(); }

}  // namespace arap
