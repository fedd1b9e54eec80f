// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/surface_arap.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/available_memory.h"
#include "base/format_message.h"
#include "models/input_checks.h"
#include "models/model_space.h"
#include "models/surface_arap/surface_model.h"
#include "optimize/engine.h"
#include "parallel/parallel.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

/// Radius of a patch, in rigidity radii.
constexpr double kPatchRadius = 1.5;

/// A little more than what a bind takes at its peak, beside the mesh. Measured on regular meshes of triangles and
/// quads, and on one with 200 faces a vertex.
double bytes_to_bind(const PolygonMesh& mesh, Energy energy) {
  const double per_vertex = energy == Energy::kRotationNodes ? 1450 : 900;  // a vertex is in more cells of nodes
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
      : space(mesh),
        part_of_vertex(mesh.n_vertices()),
        patch_radius(kPatchRadius * options.rigidity_radius),
        engine(prepare(mesh, options, properties, progress)) {
    for (size_t v = 0; v < part_of_vertex.size(); ++v) {
      part_of_vertex[v] = model.prepared.part_of_vertex[space.model_vertices()[v]];
      if (part_of_vertex[v] < 0) loose_vertices.push_back(static_cast<int>(v));
    }
  }

  const PreparedModel& prepare(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties,
                               const Progress& progress) {
    if (options.join_seams) space.join(mesh.same_places(choose_threads(options.threads, mesh.n_vertices())));
    space.renumber(prepare_surface(model, space.make_model(mesh), options, space.to_model(properties.stiffness),
                                   space.regions_to_model(properties.rigid_regions), progress));
    return model.prepared;
  }

  [[nodiscard]] const Workers& workers() const { return model.prepared.workers; }

  [[nodiscard]] Positions checked_to_model(const Positions& positions) const {
    require_rows("positions", positions.rows(), space.n_input_vertices());
    require_finite("positions", positions, [](int v) { return text("vertex ", v); });
    return space.to_model(positions, workers());
  }

  /// Energy of the input and gradient of the model.
  double evaluate(const Positions& positions, Positions& gradient) {
    const double energy = space.energy_to_input(engine.evaluate(checked_to_model(positions), gradient));
    if (!std::isfinite(energy) || !(gradient * space.size()).allFinite())
      throw SolverError(text("the energy at these positions is too large for a number: they are up to ",
                             space.points_to_model(positions).cwiseAbs().maxCoeff(), " sizes of the mesh away"));
    return energy;
  }

  ModelSpace space;
  SurfaceModel model;
  std::vector<int> part_of_vertex;  ///< of each vertex of the user's, -1 = loose
  std::vector<int> loose_vertices;
  double patch_radius;  ///< of patches without one
  ConstraintSet constraints;
  Engine engine;                     ///< over model
  std::unique_ptr<EdgeGraph> graph;  ///< of the model; made when first needed
};

SurfaceArap::SurfaceArap(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties,
                         const Progress& progress) {
  options.validate();
  properties.validate(mesh.n_vertices());
  require_memory(bytes_to_bind(mesh, options.energy), "this mesh");
  impl_ = std::make_unique<Impl>(mesh, options, properties, progress);
  if (impl_->model.prepared.is_large()) return_freed_memory();
}

SurfaceArap::~SurfaceArap() = default;
SurfaceArap::SurfaceArap(SurfaceArap&&) noexcept = default;
SurfaceArap& SurfaceArap::operator=(SurfaceArap&&) noexcept = default;

void SurfaceArap::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  constraints.validate(n_vertices());
  require_no_segments(constraints);
  require_movable_patches(constraints.patches, impl_->part_of_vertex);
  if (impl_->engine.has_constraints() && constraints == impl_->constraints) return;
  ConstraintSet copy = constraints;
  impl_->engine.set_constraints({impl_->space.to_model(constraints), {}}, progress);
  impl_->constraints = std::move(copy);
}

SolveResult SurfaceArap::solve(const Positions& targets, const SolveOptions& options,
                               std::span<const Matrix3> rotations, const Progress& progress, std::span<float> out) {
  options.validate();
  require_constrained(impl_->engine.has_constraints());
  require_targets(impl_->constraints, targets, rotations);
  require_out(out, n_vertices());
  const ModelSpace& space = impl_->space;
  SolveResult result;
  const auto hand_over = [&](const Positions& positions) {
    if (!out.empty()) return space.write_to_input(positions, impl_->workers(), out);
    result.positions = space.to_input(positions, impl_->workers());
    return all_finite(positions, impl_->workers());
  };
  IterationReport report;
  try {
    report = impl_->engine.solve(space.targets_to_model(targets, impl_->constraints), options, rotations, progress,
                                 hand_over);
  } catch (...) {
    if (!out.empty()) static_cast<void>(space.write_to_input(impl_->engine.positions(), impl_->workers(), out));
    throw;
  }
  result.energy_before = space.energy_to_input(report.energy_before);
  result.energy_after = space.energy_to_input(report.energy_after);
  result.iterations = report.iterations;
  result.step = report.step;
  result.stop_reason = report.stop_reason;
  result.parts_at_rest = impl_->engine.parts_at_rest();
  result.loose_vertices = impl_->loose_vertices;
  return result;
}

Patch SurfaceArap::patch_around(const std::vector<int>& vertices, double radius) {
  require_patch_sources(vertices, radius, impl_->part_of_vertex);
  const SurfaceModel& model = impl_->model;
  const ModelSpace& space = impl_->space;
  if (impl_->graph == nullptr)
    impl_->graph =
        std::make_unique<EdgeGraph>(model.prepared.energy.K, model.prepared.rest, impl_->workers().threads());
  std::vector<int> sources;
  sources.reserve(vertices.size());
  for (const int v : vertices) sources.push_back(space.model_vertices()[v]);
  Patch patch =
      find_patch(*impl_->graph, model.areas, model.prepared.rest, sources, radius > 0 ? radius : impl_->patch_radius);
  for (int& v : patch.vertices) v = space.input_vertices()[v];
  patch.rest_position = space.to_input(Eigen::RowVector3d(patch.rest_position)).transpose();
  return patch;
}

void SurfaceArap::reset() { impl_->engine.reset(); }

void SurfaceArap::set_positions(const Positions& positions) {
  impl_->engine.set_positions(impl_->checked_to_model(positions));
}

Positions SurfaceArap::positions() const { return impl_->space.to_input(impl_->engine.positions(), impl_->workers()); }

double SurfaceArap::energy(const Positions& positions) {
  Positions gradient;
  return impl_->evaluate(positions, gradient);
}

Positions SurfaceArap::energy_gradient(const Positions& positions) {
  Positions gradient;
  impl_->evaluate(positions, gradient);
  return impl_->space.gradient_to_input(gradient);
}

int SurfaceArap::n_vertices() const { return impl_->space.n_input_vertices(); }
int SurfaceArap::n_parts() const { return impl_->model.prepared.n_parts; }
const std::vector<int>& SurfaceArap::part_of_vertex() const { return impl_->part_of_vertex; }
const std::vector<int>& SurfaceArap::loose_vertices() const { return impl_->loose_vertices; }
int SurfaceArap::n_factorizations() const { return impl_->engine.n_factorizations(); }
int SurfaceArap::threads() const { return impl_->workers().threads(); }

}  // namespace arap
