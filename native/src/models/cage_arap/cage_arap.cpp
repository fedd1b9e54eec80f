// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/cage_arap.h"

#include <utility>

#include "base/eigen_compat.h"
#include "cages/cage_checks.h"
#include "cages/cage_points.h"
#include "mesh/surface_measures.h"
#include "models/cage_arap/cage_energy.h"
#include "models/cage_arap/cage_holds.h"
#include "models/cage_deformation/cage_fit.h"
#include "models/input_checks.h"
#include "models/model_space.h"
#include "models/user_vertices.h"
#include "optimize/engine.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

CageOptions of_points(const CageArapOptions& options) {
  CageOptions result;
  result.coordinates = options.coordinates;
  result.grid_spacing = options.grid_spacing;
  result.threads = options.threads;
  return result;
}

/// The mesh without its loose vertices, which a cage has no use for: a far one would take digits from all others.
PolygonMesh without_loose(const PolygonMesh& mesh) {
  const std::vector<int> used = vertices_in_faces(mesh);
  std::vector<int> number(mesh.n_vertices(), -1);
  for (size_t k = 0; k < used.size(); ++k) number[used[k]] = static_cast<int>(k);
  std::vector<int> corners;
  std::vector<int> sizes;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    for (const int v : mesh.face(f)) corners.push_back(number[v]);
    sizes.push_back(static_cast<int>(mesh.face(f).size()));
  }
  return {mesh.positions()(used, all), std::move(corners), std::move(sizes)};
}

}  // namespace

void CageArapOptions::validate() const {
  of_points(*this).validate();
  if (coordinates == CageCoordinates::kGreen)
    throw InvalidInput("Green coordinates are not linear in the cage; take mean value or harmonic coordinates");
  Options of_mesh;
  of_mesh.rigidity_radius = rigidity_radius;
  of_mesh.validate();
}

struct CageArap::Impl {
  Impl(const PolygonMesh& input, const PolygonMesh& input_cage, const CageArapOptions& options, Meter& meter)
      : space(input),
        mesh(space.make_model(input)),
        carried(vertices_in_faces(mesh)),
        rest_of_cage(input_cage.positions()),
        in_cage(vertices_in_faces(input_cage)),
        cage(space.beside_model(without_loose(input_cage))),
        points(cage, mesh.positions()(carried, all), of_points(options), {&meter, 0.5}),
        areas(vertex_areas(mesh)),
        engine(prepare(options, {&meter, 0.5})),
        user(space, mesh.part_of_vertex(), points.workers()),
        fit(points),
        shown(mesh.positions()) {
    point_of_vertex.assign(mesh.n_vertices(), -1);
    for (size_t k = 0; k < carried.size(); ++k) point_of_vertex[carried[k]] = static_cast<int>(k);
  }

  const PreparedModel& prepare(const CageArapOptions& options, const MeterPart& meter) {
    model.workers = Workers(choose_threads(options.threads, mesh.n_vertices()));
    assemble_cage_energy(model, cage, mesh, carried, points, options, meter);
    model.choose_precision();
    model.solver = model.make_solver();
    model.keep_numbers();
    return model;
  }

  void set_constraints(const ConstraintSet& set, const Progress& progress) {
    user.require_constraints(set);
    if (engine.has_constraints() && set == constraints) return;
    ConstraintSet copy = set;
    constexpr double kHolds = .8;  // of the time
    const Progress of_holds = part_of(progress, 0, kHolds);
    Meter meter(of_holds, "setting constraints was cancelled");
    meter.tell();
    CageHolds next(points, point_of_vertex, mesh, areas, cage, model.energy.K.diagonal().mean(), space.to_model(set),
                   {&meter, 1});
    engine.take(engine.prepare({{}, next.rows(), next.handle_of_row()}, part_of(progress, kHolds, 1)));
    holds = std::move(next);
    constraints = std::move(copy);
  }

  SolveResult solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                    const Progress& progress, std::span<float> out) {
    const Positions of_model = space.targets_to_model(targets, constraints);
    std::vector<Matrix3> of_rows;
    if (!rotations.empty())
      for (const int source : holds.sources())
        of_rows.push_back(source < 0 ? Matrix3(Matrix3::Identity()) : rotations[source]);
    SolveResult result;
    result.parts_at_rest = holds.parts_at_rest();
    result.loose_vertices = user.loose_vertices();
    Positions next = mesh.positions();
    for (size_t k = 0; k < constraints.vertices.size(); ++k)
      if (const int v = constraints.vertices[k]; point_of_vertex[v] < 0)
        next.row(v) = of_model.row(static_cast<Eigen::Index>(k));
    IterationReport report;
    user.guarded(out, shown, [&] {
      report = engine.solve(holds.targets(of_model), options, of_rows, progress, [&](const Positions& cage_positions) {
        embed(cage_positions, next);
        return user.hand_over(next, out, result);
      });
    });
    if (report.stop_reason != StopReason::kCancelled)
      shown.swap(next);
    else
      static_cast<void>(user.hand_over(shown, out, result));
    result.energy_before = space.energy_to_input(report.energy_before, 2);
    result.energy_after = space.energy_to_input(report.energy_after, 2);
    result.iterations = report.iterations;
    result.step = report.step;
    result.stop_reason = report.stop_reason;
    return result;
  }

  /// Writes where the cage brings the vertices in faces.
  void embed(const Positions& cage_positions, Positions& of_vertices) const {
    points.deform(cage_positions,
                  [&](int p, const Vector3& place) { of_vertices.row(carried[p]) = place.transpose(); });
  }

  void set_positions(const Positions& positions) {
    Positions next = user.checked_to_model(positions);
    constexpr double kSmoothness = 1e-6;
    Pose pose = engine.fitted(fit.fit(next(carried, all), kSmoothness));
    embed(pose.positions, next);
    take(std::move(pose), std::move(next));
  }

  void reset() { take(engine.at_rest(), mesh.positions()); }

  void take(Pose of_cage, Positions of_mesh) noexcept {
    engine.take(std::move(of_cage));
    shown.swap(of_mesh);
  }

  ModelSpace space;
  PolygonMesh mesh;          ///< in model space
  std::vector<int> carried;  ///< vertices of the mesh, one a point
  Positions rest_of_cage;    ///< as given
  std::vector<int> in_cage;  ///< of its vertices, those in faces
  PolygonMesh cage;          ///< in model space, of these alone
  CagePoints points;
  std::vector<double> areas;
  PreparedModel model;
  Engine engine;
  UserVertices user;
  CageFit fit;
  std::vector<int> point_of_vertex;  ///< -1: loose
  ConstraintSet constraints;
  CageHolds holds;
  Positions shown;  ///< of the mesh
};

CageArap::CageArap(const PolygonMesh& mesh, const PolygonMesh& cage, const CageArapOptions& options,
                   const Progress& progress) {
  options.validate();
  require_surface(mesh);
  require_closed_cage(cage);  // with the numbers that it was given
  Meter meter(progress, "binding was cancelled");
  impl_ = std::make_unique<Impl>(mesh, cage, options, meter);
  meter.reach(1);
}

CageArap::~CageArap() = default;
CageArap::CageArap(CageArap&&) noexcept = default;
CageArap& CageArap::operator=(CageArap&&) noexcept = default;

void CageArap::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  impl_->set_constraints(constraints, progress);
}

SolveResult CageArap::solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                            const Progress& progress, std::span<float> out) {
  options.validate();
  require_constrained(impl_->engine.has_constraints());
  require_targets(impl_->constraints, targets, rotations);
  require_out(out, n_vertices());
  return impl_->solve(targets, options, rotations, progress, out);
}

void CageArap::reset() { impl_->reset(); }

void CageArap::set_positions(const Positions& positions) { impl_->set_positions(positions); }

Positions CageArap::positions() const { return impl_->space.to_input(impl_->shown, impl_->points.workers()); }
Positions CageArap::cage_positions() const {
  Positions result = impl_->rest_of_cage;
  result(impl_->in_cage, all) = impl_->space.points_to_input(impl_->engine.positions());
  return result;
}
int CageArap::n_vertices() const { return impl_->user.size(); }
int CageArap::n_cage_vertices() const { return static_cast<int>(impl_->rest_of_cage.rows()); }
int CageArap::n_parts() const { return impl_->mesh.n_parts(); }
const std::vector<int>& CageArap::part_of_vertex() const { return impl_->user.part_of_vertex(); }
const std::vector<int>& CageArap::loose_vertices() const { return impl_->user.loose_vertices(); }
int CageArap::n_parts_at_rest() const { return static_cast<int>(impl_->holds.parts_at_rest().size()); }
int CageArap::n_factorizations() const { return impl_->engine.n_factorizations(); }
int CageArap::threads() const { return impl_->model.workers.threads(); }

}  // namespace arap
